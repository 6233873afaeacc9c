#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "slipstream/cloud/cloud.h"
#include "slipstream/cloud/normals.h"
#include "slipstream/cloud/uncertainty.h"

namespace slipstream {

/// What a cloud file may hold beside position and intensity; null: not.
struct CloudExtras {
  const Normals* normals = nullptr;
  const Uncertainty* uncertainty = nullptr;
  /// Lines for people: comments of the file's header.
  std::vector<std::string> remarks{};
};

/// Throws Error unless the file's ending is one that write_cloud knows.
void require_cloud_ending(const std::filesystem::path& path);

/// Writes the cloud by the file's ending, coordinates in mm, 32-bit float:
///   .ply  binary little-endian PLY: x y z intensity [nx ny nz]
///         [sigma_coordinate sigma_x sigma_y sigma_z] red green blue, the valid points; the
///         intensity is 64-bit float, the colours are the intensity in 8 bits;
///   .pcd  binary PCD 0.7, organised: x y z intensity [normal_x normal_y normal_z]
///         [sigma_coordinate sigma_x sigma_y sigma_z] of every pixel of the picture, NaN where
///         there is no point;
///   .xyz  text: the columns of .ply less the colours, a point a line, the valid points; without
///         the remarks, as it has no header.
/// Throws Error for another ending, WorldError when it cannot be written; never leaves half a file.
void write_cloud(const std::filesystem::path& path, const Cloud& cloud,
                 const CloudExtras& extras = {});

}  // namespace slipstream
