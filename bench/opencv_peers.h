#pragma once

#include <functional>
#include <vector>

#include "slipstream/frames/frame_set.h"
#include "slipstream/geometry/scanner.h"

namespace slipstream {

// What users of OpenCV have for the same images; the frames must outlive what is returned.

/// cv::structured_light::SinusoidalPattern::computePhaseMap, method PSP: three frames to the
/// wrapped phase and no further. Empty where OpenCV was built without that module.
std::function<void()> opencv_psp(const Frames<std::uint8_t>& frames);

/// As written by hand with OpenCV's functions: sums of float images, cv::phase, cv::magnitude, and
/// cv::triangulatePoints of the lit pixels.
std::function<void()> opencv_by_hand(const Frames<std::uint8_t>& frames, const Scanner& scanner,
                                     Axis axis);

}  // namespace slipstream
