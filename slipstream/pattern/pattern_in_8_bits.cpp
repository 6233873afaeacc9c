#include "slipstream/pattern/pattern_in_8_bits.h"

#include <algorithm>

namespace slipstream {

Image<std::uint8_t> in_8_bits(const Image<std::uint16_t>& pattern) {
  Image<std::uint8_t> narrow(pattern.size());
  std::copy(pattern.begin(), pattern.end(), narrow.begin());
  return narrow;
}

}  // namespace slipstream
