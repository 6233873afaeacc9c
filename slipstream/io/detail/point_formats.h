#pragma once

#include <span>

#include "slipstream/io/cloud_file.h"

namespace slipstream {

/// PLY declaration of the intensity. MeshLab interprets a 32-bit float intensity as grey of 0 to 1
/// and paints the points white, ignoring their colours; it ignores a double.
inline constexpr const char* ply_intensity = "property double intensity\n";

// Readers of text and mesh files, mm. They throw Error, without a file name, if the data are
// malformed or truncated.

/// The lines of an XYZ file, without comments and a line of names or of the number of points.
StoredPoints xyz_points(std::span<const std::uint8_t> bytes);

/// The corners of the triangles of a binary STL file, each once, in unspecified order.
StoredPoints stl_points(std::span<const std::uint8_t> bytes);
/// The vertices and faces of an OBJ file; the intensity is the colours' luminance.
StoredPoints obj_points(std::span<const std::uint8_t> bytes);
/// The vertices of a binary glTF 2.0 file, in the camera's frame.
StoredPoints glb_points(std::span<const std::uint8_t> bytes);

}  // namespace slipstream
