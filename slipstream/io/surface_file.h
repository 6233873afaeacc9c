#pragma once

#include <filesystem>
#include <vector>

#include "slipstream/cloud/surface.h"

namespace slipstream {

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

}  // namespace slipstream
