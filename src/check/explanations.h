#pragma once

#include <optional>
#include <string>
#include <vector>

#include "check/fit.h"
#include "slipstream/check.h"
#include "slipstream/finding.h"

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

/// A mistake that people make, and what undoes it: it is tried before it is proposed.
struct PossibleMistake {
  Cause cause;
  std::vector<Remedy> remedies{};
  FrameOrder order{};                  ///< frame `order[n]` shows pattern n; empty: as given
  std::optional<Sequence> sequence{};  ///< with other settings or another axis
  std::optional<PhotometricCalibration> photometry{};
  std::optional<Scanner> scanner{};
  PictureTurn turn{};
  /// Only the best of a family is proposed, of a positive one the best by the frames alone; 0: not
  /// of a family.
  int family = 0;
  Severity severity = Severity::wrong;
  bool slipped = false;      ///< the whole cycle begins at another frame
  bool far_fetched = false;  ///< proposed only if nothing else fits
  bool geometric = false;    ///< frames and settings stay as they are
  std::size_t rank = 0;      ///< among the mistakes, simplest first
  bool approximate = false;  ///< explains enough if the frames fit better than before
};

/// The mistakes that may explain the scan, simplest first. `as_given`: the result of fit_of.
std::vector<PossibleMistake> possible_mistakes(const JudgedScan& scan, const Fit& as_given);

/// The fit of the scan with the given settings, or with a mistake undone.
Fit fit_of(const JudgedScan& scan, const PossibleMistake& mistake = {});

/// Checks that frames, sequence and scanner fit together. If they do not, names the common mistake
/// that explains it best: wrong frame order, number of periods or axis, an uncorrected response,
/// flicker, flipped pictures, or a scanner file that is inverted, for another picture size or of
/// another rig. `fit`: the result of fit_of.
ScanFindings explain(const JudgedScan& scan, const Fit& fit);

/// A mistake that, once undone, makes everything fit.
struct Explanation {
  double misfit = 0;
  std::vector<Cause> causes{};
  std::vector<Remedy> remedies{};
  std::string remark{};  ///< about the remedies
  Severity severity = Severity::wrong;
  FrameOrder order{};       ///< set if the cycle has slipped
  double median_depth = 0;  ///< in that order
};

/// The likeliest of the common mistakes, and others that explain the scan about as
/// well. Returns nullopt if none explains it, or fits far better than a scan that fits.
/// `as_given`: the result of fit_of.
std::optional<Explanation> likeliest_mistake(const JudgedScan& scan, const Fit& as_given);

/// A diagnostic of frames that contain a share of the pattern before, and the misfit without it.
struct MixedFrames {
  double misfit = 0;
  Finding finding;
};

/// nullopt unless such a share explains what does not fit.
std::optional<MixedFrames> mixed_frames(const JudgedScan& scan, const Fit& as_given);

/// Applies `first` (identity if empty), then `then`, as one order.
FrameOrder composed(const FrameOrder& first, const FrameOrder& then);

/// "2,0,1,3,4,5".
std::string text_of(const FrameOrder& order);

/// Warnings about what frames that fit cannot show, or measure badly.
std::vector<Finding> method_limits(const JudgedScan& scan, const Fit& fit);

/// Finds frames that are identical in whole or in part, or black from some row on.
std::vector<Finding> damaged_frames(const ScanSamples& samples);

/// Finds a frame that contains only ambient light: nearly uniform, and almost nowhere brighter than
/// the darkest other frame. A pattern that is dark wherever the scene lies looks the same. Requires
/// at least `fewest_groups`.
std::optional<Finding> without_pattern(const ScanSamples& samples, int n);

/// Finds lighting that prevents or degrades measurement: no, too little or too much light, ambient
/// light stronger than the projector's, or fewer bits than declared. `bits`: declared camera bits;
/// `least_modulation`: minimum of a point, grey levels of 255.
std::vector<Finding> light_faults(const FrameModel& model, const ScanSamples& samples, int bits,
                                  double least_modulation);

}  // namespace slipstream
