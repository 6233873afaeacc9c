#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "slipstream/frame_set.h"
#include "slipstream/scanner.h"

namespace slipstream {

// OpenCV equivalents for the same images; the frames must outlive the returned functions.

/// cv::structured_light::SinusoidalPattern::computePhaseMap, method PSP: three frames to the
/// wrapped phase, not further. Null if OpenCV was built without that module.
std::function<void()> opencv_psp(const Frames<std::uint8_t>& frames);

/// Written by hand with OpenCV's functions: sums of float images, cv::phase, cv::magnitude, and
/// cv::triangulatePoints of the lit pixels.
std::function<void()> opencv_by_hand(const Frames<std::uint8_t>& frames, const Scanner& scanner,
                                     Axis axis);

}  // namespace slipstream
