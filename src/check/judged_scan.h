#pragma once

#include "check/frame_model.h"
#include "check/scan_samples.h"
#include "slipstream/check.h"
#include "slipstream/scanner.h"
#include "slipstream/sequence.h"

namespace slipstream {

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
