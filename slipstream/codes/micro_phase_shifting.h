#pragma once

#include <string_view>
#include <vector>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/shift_settings.h"

namespace slipstream {

/// Micro phase shifting (Gupta and Nayar, CVPR 2012): sinusoids whose many periods differ little,
/// three steps of the first and one frame of each other. Light that is reflected from surface to
/// surface or scattered below one averages out over such narrow fringes, in all frames alike.
struct MicroPhaseShifting {
  static constexpr std::string_view name = "micro";

  std::vector<double> periods{64, 61, 59, 57, 53};  ///< of the steps, and of each frame after them
  Shifts shifts{};

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("periods", "across the projector field, of each sinusoid", self.periods);
    visit_shifts(self.shifts, visit);
  }

  /// Throws Error for settings outside their ranges.
  void require_valid() const;
  /// Pattern n at projector coordinate y, in [0, 1].
  [[nodiscard]] double shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;
};

}  // namespace slipstream
