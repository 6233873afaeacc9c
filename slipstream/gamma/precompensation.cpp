#include "slipstream/gamma/precompensation.h"

namespace slipstream {
namespace {

/// `change`: of the intensity, as a share of the largest.
template <class Change>
PatternSet changed(const PatternSet& patterns, const Change& change) {
  return {.count = patterns.count,
          .axis = patterns.axis,
          .light = {.alpha_p = 255, .beta_p = 0},
          .shape = [patterns, change](int n,
                                      double y) { return change(patterns.intensity(n, y) / 255); },
          .exposures = patterns.exposures,
          .binary = patterns.binary};
}

}  // namespace

PatternSet precompensated(const PatternSet& patterns, const Response& response) {
  return changed(patterns, [response](double light) { return value_for(response, light); });
}

PatternSet through(const PatternSet& patterns, const Response& response) {
  return changed(patterns, [response](double value) { return light_at(response, value); });
}

}  // namespace slipstream
