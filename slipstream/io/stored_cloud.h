#pragma once

#include <filesystem>
#include <optional>

#include "slipstream/cloud/cloud.h"
#include "slipstream/cloud/uncertainty.h"

namespace slipstream {

/// A cloud as a file holds it.
struct StoredCloud {
  Cloud cloud{};
  std::optional<Uncertainty> uncertainty{};  ///< where the file has sigma_z
  /// Whether the cloud has a pixel for each of the camera's; else it is one row of points.
  bool organised = false;
};

/// Whether the file's ending is one that read_cloud knows.
bool is_cloud_file(const std::filesystem::path& path);

/// The points of a file that write_cloud or write_surface wrote, or others in the same formats, by
/// its ending:
///   .ply         ASCII, or binary of either byte order; the vertices of a mesh too
///   .pcd         ASCII or binary, of 32-bit float; organised where its height is more than one
///   .xyz         text, by the count of columns that write_cloud writes; or x y z alone
///   .stl         binary; the corners of its triangles, each once
///   .obj, .glb   the vertices
/// Intensity is that of the colours where there is none, and 0 where there is neither. What else
/// the file has is passed over, and so are points that are not finite. Throws Error, naming the
/// file, where it is another file, ends too soon or holds no point.
StoredCloud read_cloud(const std::filesystem::path& path);

}  // namespace slipstream
