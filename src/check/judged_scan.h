#pragma once

#include <cmath>

#include "check/frame_model.h"
#include "check/scan_samples.h"
#include "slipstream/check.h"
#include "slipstream/scanner.h"
#include "slipstream/sequence.h"

namespace slipstream {

/// Whether the optical axis lies farther from the centre of the picture than lenses put it, as if
/// the pictures were cropped after the calibration (or before it).
inline bool is_off_centre(const Lens& lens) {
  constexpr double most = 0.12;  // of the width or the height
  const double x = lens.intrinsic(0, 2) / lens.size.width;
  const double y = lens.intrinsic(1, 2) / lens.size.height;
  return std::abs(x - 0.5) > most || std::abs(y - 0.5) > most;
}

/// The inputs of a scan check. Holds references; owns nothing.
struct JudgedScan {
  const FrameModel& model;
  const ScanSamples& samples;
  const Sequence& sequence;
  const Scanner* scanner;  ///< null if unknown or already found wrong
  const PhotometricCalibration& photometry;
  const CheckSettings& settings;
  bool scanner_doubted = false;  ///< check_scanner finds something
};

}  // namespace slipstream
