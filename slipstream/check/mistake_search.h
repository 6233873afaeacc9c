#pragma once

#include <optional>
#include <string>

#include "slipstream/check/explanations.h"
#include "slipstream/check/fit.h"

namespace slipstream {

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

}  // namespace slipstream
