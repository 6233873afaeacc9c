#pragma once

#include <optional>
#include <string_view>
#include <vector>

#include "slipstream/codes/composite.h"
#include "slipstream/codes/shift_settings.h"

namespace slipstream {

/// Modulated phase shifting (after Chen, Seidel and Lensch, CVPR 2008): a base along the axis times
/// a carrier across it, 1/2 + 1/2 cos(pi f y - 2 pi n / N) cos(2 pi c x - pi m / M), the carrier
/// shifted M times for each of N shifts of the base. The product is a sum of two oblique sinusoids,
/// of pi f y + 2 pi c x and pi f y - 2 pi c x: shown one after the other, each in N steps at full
/// modulation, they give half the variance of as many frames that show both. Light that is
/// reflected from surface to surface or scattered below one reaches a pixel from many periods of
/// the carrier: it adds to the mean and to no phase, however wide the base.
struct ModulatedPhaseShifting {
  static constexpr std::string_view name = "modulated";

  int steps = 3;                       ///< N, >= 3
  std::optional<int> carrier_steps{};  ///< M, >= 2; where not given each sinusoid is shown alone
  std::vector<double> periods{1, 16};  ///< f, of each base's brightness: its sinusoid has half
  double carrier = 64;                 ///< c, periods along the other axis
  Shifts shifts{};

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("steps", "frames of each sinusoid (N >= 3)", self.steps);
    visit("carrier_steps", "shifts of the carrier for each of the base; else oblique sinusoids",
          self.carrier_steps);
    visit("periods", "across the projector field, of each sinusoid", self.periods);
    visit("carrier", "periods of the carrier, along the other axis", self.carrier);
    visit_shifts(self.shifts, visit);
  }

  /// Throws Error for settings outside their ranges.
  void require_valid() const;
  [[nodiscard]] std::vector<ShownSinusoid> sinusoids() const;
};

}  // namespace slipstream
