#pragma once

#include <span>

#include "slipstream/io/cloud_file.h"

namespace slipstream {

/// How the intensity is declared in PLY. MeshLab takes an intensity of 32-bit float for a grey of 0
/// to 1 and paints the points white with it, over their red, green and blue; of a double it knows
/// nothing.
inline constexpr const char* ply_intensity = "property double intensity\n";

// The points of mesh files, mm. They throw Error, which does not name the file, for what is no such
// file or ends too soon.

/// The corners of the triangles of a binary STL file, each once, in no order.
StoredPoints stl_points(std::span<const std::uint8_t> bytes);
/// The vertices of an OBJ file and its faces; intensity is that of the colours.
StoredPoints obj_points(std::span<const std::uint8_t> bytes);
/// The vertices of a binary glTF 2.0 file, in the camera's frame.
StoredPoints glb_points(std::span<const std::uint8_t> bytes);

}  // namespace slipstream
