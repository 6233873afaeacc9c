#pragma once

#include <cstdint>
#include <span>

#include "slipstream/cloud_file.h"

namespace slipstream {

/// The lines of an XYZ file, mm, without comments and a line of names or of the number of points.
/// Throws Error, without a file name, if the data are malformed or truncated.
StoredPoints xyz_points(std::span<const std::uint8_t> bytes);

/// The same of a .pts file, whose lines of seven numbers have x, y, z, an intensity, which is not
/// read, and a colour.
StoredPoints pts_points(std::span<const std::uint8_t> bytes);

}  // namespace slipstream
