// A strategy defined outside the library: three sinusoids, each unwrapped with the next coarser
// one.
#include <array>
#include <cmath>
#include <numbers>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/extensions/seen.h"

namespace slipstream::own_strategy_test {

struct ThreeSinusoids {
  static constexpr std::string_view name = "three-sinusoids";

  double finest = 36;

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("finest", "periods of the last three frames", self.finest);
  }
  void require_valid() const {}
  [[nodiscard]] std::array<double, 3> periods() const { return {1, 6, finest}; }
  [[nodiscard]] double shape(int n, double y) const {
    const double f = periods()[static_cast<std::size_t>(n / 3)];
    return 0.5 + 0.5 * std::cos(2 * std::numbers::pi * (f * y - n % 3 / 3.0));
  }
  [[nodiscard]] Layout layout() const {
    const auto [f_0, f_1, f_2] = periods();
    return {.frames = 9,
            .bands = {phase_shifted_band(9, 0, 3, f_0), phase_shifted_band(9, 3, 3, f_1),
                      phase_shifted_band(9, 6, 3, f_2)},
            .unwrapping = Unwrapping::hierarchical};
  }
};

TEST(Strategy, OwnStrategyIsReconstructedByTheFusedPass) {
  const Seen seen = seen_under(ThreeSinusoids{.finest = 30});
  Engine engine(seen.setup);
  EXPECT_EQ(engine.backend_for(seen.scan.frames), "fused");
  expect_true_depths(seen, engine);
}

}  // namespace slipstream::own_strategy_test
