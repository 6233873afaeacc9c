#pragma once

#include <filesystem>
#include <optional>

#include "slipstream/cloud/cloud.h"
#include "slipstream/cloud/surface.h"

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

/// Throws Error unless the file's ending is one that write_surface knows.
void require_mesh_ending(const std::filesystem::path& path);

/// The picture and the materials that write_surface leaves beside an .obj file; none beside others.
std::vector<std::filesystem::path> files_beside(const std::filesystem::path& surface);

/// Writes a surface by the file's ending, as read_cloud reads its vertices:
///   .ply  binary little-endian PLY: x y z intensity red green blue of the vertices, triangles;
///   .stl  binary STL: triangles with their normals, no texture;
///   .obj  text, with NAME.mtl and NAME-texture.png beside it, and the vertices' colours;
///   .glb  binary glTF 2.0 with the texture in it: metres, y up, z towards the camera; the
///         intensity is the attribute _INTENSITY.
/// All but .glb in mm, in the camera's frame. Throws Error for another ending, WorldError when it
/// cannot be written; never leaves half a file.
void write_surface(const std::filesystem::path& path, const Surface& surface);

/// A cloud as a file holds it.
struct StoredCloud {
  Cloud cloud{};
  std::optional<Uncertainty> uncertainty{};  ///< where the file has sigma_z
  /// Whether the cloud has a pixel for each of the camera's; else it is one row of points.
  bool organised = false;
};

/// Whether the file's ending is one that read_cloud and read_points know.
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

/// A point as a file says it; 0 what it does not say.
struct StoredPoint {
  double x = 0, y = 0, z = 0, intensity = 0;
  double sigma_coordinate = 0, sigma_x = 0, sigma_y = 0, sigma_z = 0;
};

/// What a file says, before it is a cloud or a mesh.
struct StoredPoints {
  std::vector<StoredPoint> points{};
  /// Faces of .ply and .obj, as fans, by their corners' indices; these are not checked.
  std::vector<std::array<int, 3>> triangles{};
  bool has_sigma = false;
  Size organised{};  ///< as so many columns and rows; 0: not
};

/// What read_cloud reads, and the faces of meshes. Throws Error, naming the file, where it is
/// another file or ends too soon.
StoredPoints read_points(const std::filesystem::path& path);

}  // namespace slipstream
