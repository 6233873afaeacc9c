#pragma once

#include <cstdint>
#include <span>

#include "slipstream/simulate/mesh.h"

namespace slipstream {

/// The mesh in a PLY file (ASCII, binary of either byte order): x y z of its vertices, its faces as
/// fans of triangles; other elements and properties are passed over. Throws Error, which does not
/// name the file, for what is no PLY file or ends too soon. The faces' indices are not checked.
Mesh ply_mesh(std::span<const std::uint8_t> bytes);

}  // namespace slipstream
