#pragma once

#include <string>

#include "base/page.h"
#include "calibrate/hand_eye.h"

namespace slipstream {

/// A summary of a few lines: conventions, result with standard deviations, errors, more poses.
std::string text_of(const HandEye& found);

/// The full report: diagnostics, the summary's numbers and the errors of each pose.
Page hand_eye_report(const HandEye& found, Wording wording);

/// The errors of each pose as YAML, a map for each: name, used, error_mm, error_degrees,
/// left_out_mm, left_out_degrees, reason.
std::string residuals_yaml(const HandEye& found);

/// "tool" if the camera is on it, else "base".
std::string carrier_of_camera(EyePlace place);

}  // namespace slipstream
