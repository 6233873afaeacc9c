#include "slipstream/pattern/pattern_in_8_bits.h"

#include <algorithm>

namespace slipstream {

Image<std::uint8_t> in_8_bits(const Image<std::uint16_t>& pattern) {
  Image<std::uint8_t> narrow(pattern.size());
  std::copy(pattern.begin(), pattern.end(), narrow.begin());
  return narrow;
}

std::vector<Image<std::uint8_t>> patterns_in_8_bits(const PatternSet& set, Size projector) {
  std::vector<Image<std::uint8_t>> patterns;
  for (int n = 0; n < set.count; ++n)
    patterns.push_back(in_8_bits(render_pattern(set, n, projector)));
  return patterns;
}

}  // namespace slipstream
