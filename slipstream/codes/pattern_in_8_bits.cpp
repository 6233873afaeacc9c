#include "slipstream/codes/pattern_in_8_bits.h"

#include <algorithm>
#include <cstddef>

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

Image<Colour> picture_in_colour(const PatternSet& set, int first, Size projector) {
  const Image<std::uint16_t> red = render_pattern(set, first, projector),
                             green = render_pattern(set, first + 1, projector),
                             blue = render_pattern(set, first + 2, projector);
  Image<Colour> picture(projector);
  for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
    const auto level = [&](const Image<std::uint16_t>& pattern) {
      return static_cast<std::uint8_t>(pattern.begin()[i]);
    };
    picture.begin()[i] = {level(red), level(green), level(blue)};
  }
  return picture;
}

}  // namespace slipstream
