#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "slipstream/cloud_file.h"
#include "slipstream/surface.h"

namespace slipstream {

/// The bytes of a binary glTF 2.0 file: see write_surface.
std::string glb_file(const Surface& surface);

/// The vertices of such a file. Throws Error, without a file name, if it is malformed or truncated.
StoredPoints glb_points(std::span<const std::uint8_t> bytes);

}  // namespace slipstream
