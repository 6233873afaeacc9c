#pragma once

#include <cstdint>
#include <span>

#include "slipstream/cloud_file.h"

// Readers of mesh files, mm. They throw Error, without a file name, if the data are malformed or
// truncated. slipstream/cloud_file.h declares the writers.
namespace slipstream {

/// The corners of the triangles of a binary STL file, each once, in unspecified order.
StoredPoints stl_points(std::span<const std::uint8_t> bytes);

/// The vertices and faces of an OBJ file; the intensity is the colours' luminance.
StoredPoints obj_points(std::span<const std::uint8_t> bytes);

}  // namespace slipstream
