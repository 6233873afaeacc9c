#pragma once

#include <array>

#include "slipstream/codes/pattern_set.h"

namespace slipstream {

/// What a projector in colour shows for its mixture to be measured, all over, by name.
inline constexpr std::array primary_names{"black", "red", "green", "blue"};

/// Half of the light that a projector has, of all colours, as patterns have in the mean: it tells
/// paint from pattern.
inline PatternSet white_pattern(const PatternLight& light) {
  return {.count = 3, .light = light, .shape = [](int, double) { return 0.5; }};
}

/// The pictures of those names as three patterns each, of their channels.
inline PatternSet primary_patterns(const PatternLight& light) {
  constexpr int channels = 3;
  return {.count = channels * static_cast<int>(primary_names.size()),
          .light = light,
          .shape = [](int n, double) { return n / channels == n % channels + 1 ? 1.0 : 0.0; }};
}

}  // namespace slipstream
