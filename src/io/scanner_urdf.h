#pragma once

#include <string>

#include "slipstream/scanner.h"

namespace slipstream {

/// The frames of a scanner for ROS, in metres, as REP 103 has them: camera_link (x forward, y left,
/// z up), camera_optical (x right, y down, z forward), which is the frame of clouds, and projector,
/// with the axes of an optical frame.
std::string urdf_of(const Scanner& scanner);

/// The same as a macro of xacro, slipstream_scanner, with a prefix of the names, the link that
/// carries the scanner, and the place of camera_link on it.
std::string xacro_of(const Scanner& scanner);

}  // namespace slipstream
