#pragma once

#include <cstdint>
#include <span>
#include <string>

#include "slipstream/cloud/surface.h"
#include "slipstream/io/detail/stored_points.h"

namespace slipstream {

/// A binary glTF 2.0 file, as write_surface says.
std::string glb_file(const Surface& surface);

/// The vertices of such a file, in the camera's frame, mm. Throws Error, which does not name the
/// file, for what is no such file or ends too soon.
StoredPoints glb_points(std::span<const std::uint8_t> bytes);

}  // namespace slipstream
