#pragma once

#include <string>
#include <vector>

#include "slipstream/calibrate/geometry_calibration.h"

namespace slipstream {

/// What a person should know before trusting a calibration, a line each, in plain words.
std::vector<std::string> warnings_about(const GeometryCalibration& calibration);

}  // namespace slipstream
