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
///         [sigma_coordinate sigma_x sigma_y sigma_z], the valid points; the picture's
///         size stands in obj_info num_cols, num_rows;
///   .pcd  binary PCD 0.7, organised: every pixel of the picture, NaN where there is no point;
///   .xyz  text: x y z intensity, a point a line, the valid points.
/// The extras are not written to .xyz, which has no header. Throws Error for another ending,
/// WorldError when it cannot be written; never leaves half a file.
void write_cloud(const std::filesystem::path& path, const Cloud& cloud,
                 const CloudExtras& extras = {});

/// The points of a PLY file (ASCII, binary of either byte order), as one row: x y z of its
/// vertices, and their intensity, which is that of the colours where it has red green blue, and 0
/// where it has neither; other elements and properties are passed over, and points that are not
/// finite are left out. Throws Error, naming the file, for what is no PLY file, ends too soon, or
/// holds no point.
Cloud read_cloud(const std::filesystem::path& path);

}  // namespace slipstream
