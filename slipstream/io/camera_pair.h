#pragma once

#include <filesystem>

#include "slipstream/geometry/scanner.h"

namespace slipstream {

/// Reads the calibration of two cameras without a projector, as read_scanner: slipstream's layout
/// with second_camera_matrix, second_camera_distortion, second_camera_width and
/// second_camera_height in place of the projector's, or another tool's that only numbers its
/// devices. The second camera is the result's `projector`.
Scanner read_camera_pair(const std::filesystem::path& path);

/// Whether the file calibrates two cameras by slipstream's names or, with `if_either`, may do so by
/// another tool's.
bool is_camera_pair(const std::filesystem::path& path, bool if_either);

}  // namespace slipstream
