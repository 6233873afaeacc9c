#include "slipstream/response/precompensation.h"

namespace slipstream {

PatternSet precompensated(const PatternSet& patterns, const Response& response) {
  PatternSet changed = patterns;
  changed.light = {.alpha_p = 255, .beta_p = 0};
  changed.shape = [patterns, response](int n, double y, double across) {
    return value_for(response, patterns.intensity(n, y, across) / 255);
  };
  return changed;
}

}  // namespace slipstream
