#pragma once

#include <optional>
#include <string>
#include <vector>

#include "check/fit.h"
#include "check/judged_scan.h"
#include "check/possible_mistakes.h"
#include "slipstream/finding.h"

namespace slipstream {

/// The fit of the scan with the given settings, or with a mistake undone.
Fit fit_of(const JudgedScan& scan, const PossibleMistake& mistake = {});

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

/// Moves causes, remedies and remark of the explanation into the finding.
void give_causes(Explanation& explanation, Finding& finding);

/// A mistake undone, and how the scan fits then.
struct Attempt {
  PossibleMistake mistake;
  Fit fit;
  double misfit = 0;
};

/// Words for the likeliest, and for others that fit about as well. A far-fetched one is named only
/// if nothing else fits. `attempts`: not empty, likeliest first. `in_force`: order of the frames.
Explanation explanation_from(const std::vector<Attempt>& attempts, const FrameOrder& in_force = {});

/// The likeliest of the common mistakes, and others that explain the scan about as
/// well. Returns nullopt if none explains it, or fits far better than a scan that fits.
/// `as_given`: the result of fit_of.
std::optional<Explanation> likeliest_mistake(const JudgedScan& scan, const Fit& as_given);

}  // namespace slipstream
