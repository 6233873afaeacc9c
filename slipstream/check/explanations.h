#pragma once

#include <vector>

#include "slipstream/check/finding.h"
#include "slipstream/check/frame_evidence.h"

namespace slipstream {

/// What a scan is judged by; refers to, does not own.
struct JudgedScan {
  const FrameModel& model;
  const ScanSamples& samples;
  const Sequence& sequence;
  const Scanner* scanner;  ///< null where it is not known, or cannot be right
  const PhotometricCalibration& photometry;
  bool moving = false;  ///< CheckSettings::moving
  FrameOrder order{};   ///< CheckSettings::order
};

struct Explained {
  std::vector<Finding> findings;
  FrameOrder order;  ///< that sets a slip right; empty where there is none
};

/// Whether frames, sequence and scanner fit together; where they do not, of the usual mistakes the
/// one without which they would: another order of the frames, number of periods or axis, a response
/// that is not corrected, light that flickers, pictures turned over, a scanner file that is
/// inverted, for another size, or of another rig.
Explained explain(const JudgedScan& scan);

}  // namespace slipstream
