#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "check/fit.h"
#include "check/judged_scan.h"
#include "slipstream/finding.h"
#include "slipstream/scanner.h"
#include "slipstream/sequence.h"

namespace slipstream {

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

}  // namespace slipstream
