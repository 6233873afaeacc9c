#pragma once

#include "slipstream/codes/sinusoid.h"

namespace slipstream {

/// The settings that every coding of sinusoids has, so that patterns made elsewhere can be
/// described: see Strategy.
template <class AnyShifts, class Visit>
void visit_shifts(AnyShifts& shifts, const Visit& visit) {
  visit("origin", "phase of the first frame at the field's edge, rad", shifts.origin);
  visit("backwards", "phases fall from frame to frame by what else they rise", shifts.backwards);
}

}  // namespace slipstream
