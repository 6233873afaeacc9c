// An unwrapping method defined outside the library: picks the pair of fringe orders for which the
// coordinates of two sinusoids agree best.
#include "slipstream/unwrapping.h"

#include <cmath>
#include <functional>
#include <numbers>
#include <string_view>

#include <gtest/gtest.h>

#include "tests/extensions/seen.h"

namespace slipstream::own_unwrapping_test {

std::function<PixelCoordinate(const PixelReading&)> by_agreement(const Layout& layout, int) {
  return [f_0 = layout.bands[0].periods, f_1 = layout.bands[1].periods](const PixelReading& pixel) {
    PixelCoordinate best{.y = 0, .doubt = 1};
    for (int k_0 = 0; k_0 < f_0; ++k_0) {
      for (int k_1 = 0; k_1 < f_1; ++k_1) {
        const double y_0 = unwrapped_coordinate(pixel.phases[0], k_0, f_0);
        const double y_1 = unwrapped_coordinate(pixel.phases[1], k_1, f_1);
        const double apart = std::abs(y_0 - y_1) * f_1;
        if (apart < best.doubt) best = {.y = y_1, .doubt = apart};
      }
    }
    return best;
  };
}

constexpr UnwrappingWay agreement{
    .name = "agreement", .order_source = OrderSource::pixel, .pixel = by_agreement};

struct TwoSinusoids {
  static constexpr std::string_view name = "two-sinusoids";

  template <class Self, class Visit>
  static void for_each_setting(Self&, const Visit&) {}
  void require_valid() const {}
  [[nodiscard]] double shape(int n, double y) const {
    return 0.5 + 0.5 * std::cos(2 * std::numbers::pi * ((n < 4 ? 5 : 7) * y - n % 4 / 4.0));
  }
  [[nodiscard]] Layout layout() const {
    return {.frames = 8,
            .bands = {phase_shifted_band(8, 0, 4, 5), phase_shifted_band(8, 4, 4, 7)},
            .unwrapping = agreement};
  }
};

TEST(Unwrapping, OwnUnwrappingIsDoneByTheReferenceEngine) {
  const Seen seen = seen_under(TwoSinusoids{});
  Engine engine(seen.setup);
  EXPECT_NE(engine.backend_for(seen.scan.frames), "fused");
  expect_true_depths(seen, engine);
}

}  // namespace slipstream::own_unwrapping_test
