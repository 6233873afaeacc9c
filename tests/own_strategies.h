// Strategies of one's own: structs that no part of the library knows.
#pragma once

#include <array>
#include <cmath>
#include <numbers>
#include <string_view>
#include <vector>

#include "slipstream/strategy.h"

namespace slipstream {

/// A cosine, a sine and the mean itself, one frame each: no run of steps.
struct CosineSineMean {
  static constexpr std::string_view name = "cosine-sine-mean";

  template <class Self, class Visit>
  static void for_each_setting(Self&, const Visit&) {}

  void require_valid() const {}
  [[nodiscard]] double shape(int n, double y) const {
    const double angle = 2 * std::numbers::pi * y;
    const std::array waves{std::cos(angle), std::sin(angle), 0.0};
    return 0.5 + 0.5 * waves[static_cast<std::size_t>(n)];
  }
  [[nodiscard]] Layout layout() const {
    return {.frames = 3, .bands = {{.cosine = {1, 0, -1}, .sine = {0, 1, -1}, .mean = {0, 0, 1}}}};
  }
};

/// Three sinusoids of three steps each, shown in any order; each is unwrapped by the next coarser.
struct ThreeFrequencies {
  static constexpr std::string_view name = "three-frequencies";

  double first = 1, second = 6, third = 36;

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("first", "periods of the first three frames", self.first);
    visit("second", "periods of the next three", self.second);
    visit("third", "periods of the last three", self.third);
  }

  void require_valid() const {}
  [[nodiscard]] double shape(int n, double y) const {
    const double f = std::array{first, second, third}[static_cast<std::size_t>(n / 3)];
    return 0.5 + 0.5 * std::cos(2 * std::numbers::pi * (f * y - n % 3 / 3.0));
  }
  [[nodiscard]] Layout layout() const {
    return {.frames = 9,
            .bands = {phase_shifted_band(9, 0, 3, first), phase_shifted_band(9, 3, 3, second),
                      phase_shifted_band(9, 6, 3, third)},
            .unwrapping = Unwrapping::hierarchical};
  }
};

inline std::vector<Strategy> own_strategies() {
  return {CosineSineMean{}, ThreeFrequencies{},
          ThreeFrequencies{.first = 36, .second = 1, .third = 6}};
}

}  // namespace slipstream
