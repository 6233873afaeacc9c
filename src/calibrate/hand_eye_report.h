#pragma once

#include <string>

#include "base/page.h"
#include "calibrate/hand_eye.h"

namespace slipstream {

/// A summary of a few lines: conventions, result with standard deviations, errors, more poses.
std::string text_of(const HandEye& found);

/// The full report: diagnostics, the summary's numbers and the errors of each pose.
Page hand_eye_report(const HandEye& found, Wording wording);

/// "tool" if the camera is on it, else "base".
std::string carrier_of_camera(EyePlace place);

}  // namespace slipstream
