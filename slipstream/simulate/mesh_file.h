#pragma once

#include <filesystem>

#include "slipstream/simulate/mesh.h"

namespace slipstream {

/// Reads the triangles of a PLY or OBJ file, all its parts as one mesh, in the file's units and
/// axes. Throws Error, naming the file, when it cannot be read or has no triangle.
Mesh read_mesh(const std::filesystem::path& path);

}  // namespace slipstream
