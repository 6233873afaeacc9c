#include "slipstream/decode/modulation_mask.h"

#include <algorithm>

namespace slipstream {

Image<std::uint8_t> modulation_mask(const Image<double>& modulation, double minimum) {
  Image<std::uint8_t> mask(modulation.size());
  std::transform(modulation.begin(), modulation.end(), mask.begin(),
                 [minimum](double B) -> std::uint8_t { return B >= minimum ? 1 : 0; });
  return mask;
}

}  // namespace slipstream
