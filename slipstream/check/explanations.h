#pragma once

#include "slipstream/check/fit.h"
#include "slipstream/check/scan_check.h"
#include "slipstream/codes/layout.h"

namespace slipstream {

/// What a scan is judged by; refers to, does not own.
struct JudgedScan {
  const FrameModel& model;
  const ScanSamples& samples;
  const Sequence& sequence;
  const Scanner* scanner;  ///< null where it is not known, or cannot be right
  const PhotometricCalibration& photometry;
  const CheckSettings& settings;
};

/// Whether frames, sequence and scanner fit together; where they do not, of the usual mistakes the
/// one without which they would: another order of the frames, number of periods or axis, a response
/// that is not corrected, light that flickers, pictures turned over, a scanner file that is
/// inverted, for another size, or of another rig.
ScanFindings explain(const JudgedScan& scan);

/// A mistake without which all would fit.
struct Explanation {
  double misfit = 0;
  std::string likely{}, advice{};
  Gravity gravity = Gravity::wrong;
  FrameOrder order{};  ///< where the cycle has slipped
  bool far_fetched = false;
};

/// How the scan fits as it is given.
Fit fit_as_given(const JudgedScan& scan);

/// Of the usual mistakes the one without which all would fit, its words with those of others that
/// fit about as well; none where no one does. `as_given` is what fit_as_given says.
std::optional<Explanation> likeliest_mistake(const JudgedScan& scan, const Fit& as_given);

/// The one order that does what `first` does, nothing where it is empty, and then `then`.
FrameOrder composed(const FrameOrder& first, const FrameOrder& then);

/// "2,0,1,3,4,5".
std::string text_of(const FrameOrder& order);

/// Frames that are the same picture, whole or in part, or black from some row on.
std::vector<Finding> damaged_frames(const ScanSamples& samples);

/// Frames without any pattern. A pattern that is dark wherever the scene is looks alike: to be
/// asked where the frames do not fit each other. `samples` has at least `fewest_groups`.
std::vector<Finding> frames_without_pattern(const ScanSamples& samples);

/// Light that no point can be measured in, or that spoils points: none, too little, too much, more
/// of the room's than of the projector's, fewer bits than said.
/// `bits`: of the camera, as said; `least_modulation`: of a point, grey levels of 255.
std::vector<Finding> light_faults(const FrameModel& model, const ScanSamples& samples, int bits,
                                  double least_modulation);

}  // namespace slipstream
