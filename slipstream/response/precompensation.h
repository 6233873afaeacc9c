#pragma once

#include "slipstream/codes/pattern_set.h"
#include "slipstream/codes/response.h"

namespace slipstream {

/// The pictures that a projector of that response turns into the light of `patterns`: the inverse
/// response is applied before projection. What people do instead of correcting the phase; it costs
/// grey levels, because the pictures are rounded to the projector's after it.
PatternSet precompensated(const PatternSet& patterns, const Response& response);

}  // namespace slipstream
