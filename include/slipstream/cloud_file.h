#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/cloud.h"
#include "slipstream/surface.h"

namespace slipstream {

/// Optional contents of a cloud file besides position and intensity; null: omitted.
struct CloudExtras {
  const Normals* normals = nullptr;
  const Uncertainty* uncertainty = nullptr;
  /// Comments in the file's header, one line each.
  std::vector<std::string> remarks{};
  /// Pose between the cloud's frame and the one to write in, in either direction; null: the
  /// cloud's.
  std::shared_ptr<const FramePose> frame{};
};

/// Throws Error unless write_cloud supports the file's ending.
void require_cloud_ending(const std::filesystem::path& path);

/// Writes the cloud in the format of the file's ending, or as PLY to standard_output, coordinates
/// in mm, 32-bit float. The header names their frame and, if it is not the camera's, has the
/// camera's place there; read_cloud reads both:
///   .ply  binary little-endian PLY: x y z intensity [nx ny nz]
///         [sigma_coordinate sigma_x sigma_y sigma_z [systematic_z]] red green blue, the valid
///         points; the intensity is 64-bit float, the colours are sRGB, or the intensity in 8 bits;
///   .pcd  binary PCD 0.7, organised: x y z intensity [normal_x normal_y normal_z]
///         [sigma_coordinate sigma_x sigma_y sigma_z [systematic_z]] [rgb] of every pixel of the
///         picture, NaN without a point; rgb is a float whose bytes are blue, green, red and 0, as
///         in PCL;
///   .xyz  text: the columns of .ply without systematic_z and colours, one valid point a line; no
///         remarks, since it has no header.
/// Throws Error for another ending, WorldError if it cannot be written; never leaves a partial
/// file.
void write_cloud(const std::filesystem::path& path, const Cloud& cloud,
                 const CloudExtras& extras = {});

/// The bytes of such a file, by its ending: ".ply", ".pcd" or ".xyz". Throws Error for another.
std::string cloud_bytes(const std::string& ending, const Cloud& cloud,
                        const CloudExtras& extras = {});

/// Throws Error unless write_surface supports the file's ending.
void require_mesh_ending(const std::filesystem::path& path);

/// The texture and material files that write_surface writes beside an .obj file; empty for others.
std::vector<std::filesystem::path> files_beside(const std::filesystem::path& surface);

/// Writes a surface in the format of the file's ending; read_cloud can read its vertices:
///   .ply  binary little-endian PLY: x y z intensity red green blue of the vertices, triangles;
///   .stl  binary STL: triangles with their normals, no texture;
///   .obj  text, with NAME.mtl and NAME-texture.png beside it, and the vertices' colours;
///   .glb  binary glTF 2.0: metres, y up, z towards the camera; the intensity is the attribute
///         _INTENSITY; with an embedded grey texture, or the vertices' colours as COLOR_0, linear
///         in 16 bits.
/// All except .glb in mm, in the surface's frame. A .glb has the axes of a frame other than the
/// camera's as they are, in metres, and a node that turns its z up. Throws Error for another
/// ending, WorldError if it cannot be written; never leaves a partial file.
void write_surface(const std::filesystem::path& path, const Surface& surface);

/// A cloud as stored in a file.
struct StoredCloud {
  Cloud cloud{};
  std::optional<Uncertainty> uncertainty{};  ///< nullopt if the file has no sigma_z
  /// True if the cloud has the camera's pixel grid; otherwise it is one row of points.
  bool organised = false;
  double rounding = 0;  ///< the most that a 32-bit number differs from the file's, mm
};

/// Whether read_cloud and read_points support the file's ending.
bool is_cloud_file(const std::filesystem::path& path);

/// Reads the points of a file by write_cloud or write_surface, or of another in these formats, by
/// its ending:
///   .ply         ASCII, or binary of either byte order; also the vertices of a mesh
///   .pcd         ASCII or binary, fields of any type; organised if its height is above one
///   .xyz, .asc, .txt, .csv, .pts
///                text, separated by blanks, commas or semicolons: the columns that its first line
///                names, or those of write_cloud by their number, or x y z and a colour in whole
///                numbers
///   .stl         binary; the corners of its triangles, each once
///   .obj, .glb   the vertices
/// Without intensity, uses the colours' luminance, or 0; real colours up to 1 count from 0 to 1.
/// Ignores other properties and points that are not finite. Throws Error with the file's name if it
/// is malformed, truncated or has no points.
StoredCloud read_cloud(const std::filesystem::path& path);

/// A point as stored; missing values are 0.
struct StoredPoint {
  double x = 0, y = 0, z = 0, intensity = 0;
  double sigma_coordinate = 0, sigma_x = 0, sigma_y = 0, sigma_z = 0, systematic_z = 0;
  std::array<float, 3> colour{};  ///< red, green and blue, sRGB, 0 to 255
};

/// Contents of a file, before conversion to a cloud or mesh.
struct StoredPoints {
  std::vector<StoredPoint> points{};
  /// Faces of .ply and .obj, split into triangles; the vertex indices are not validated.
  std::vector<std::array<int, 3>> triangles{};
  bool has_sigma = false, has_systematic = false;
  bool has_colour = false;  ///< red, green and blue differ in some point
  Size organised{};         ///< columns and rows; 0 if not organised
  /// As Cloud::frame, if the file names a frame; null otherwise.
  std::shared_ptr<const FramePose> frame{};
};

/// Reads the files of read_cloud, with the faces of meshes. Throws Error with the file's name if it
/// is malformed or truncated.
StoredPoints read_points(const std::filesystem::path& path);

}  // namespace slipstream
