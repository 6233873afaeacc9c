#pragma once

#include <limits>
#include <optional>

#include "check/fit.h"
#include "check/judged_scan.h"
#include "slipstream/finding.h"

namespace slipstream {

struct ChangedLight {
  /// Misfit of the scan without the change; infinite if it does not fit then either.
  double misfit = std::numeric_limits<double>::infinity();
  Finding finding;
};

/// Detects light that changed between frames, as by flicker or automatic exposure: one gain for
/// each frame explains the residual. nullopt if it did not, or for a code whose bits are sure.
/// `fit`: the result of fit_of.
std::optional<ChangedLight> changed_light(const JudgedScan& scan, const Fit& fit);

/// Detects the same in a code with inverses: each bit and its inverse add up to the same light. A
/// code tolerates most of it. nullopt for other patterns.
std::optional<Finding> changed_light_of_code(const JudgedScan& scan);

}  // namespace slipstream
