#pragma once

#include <string_view>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/shift_settings.h"

namespace slipstream {

/// Phase measuring profilometry, PMP: N phase-shifted sinusoids of one frequency f (Liu 2010, Eqs.
/// 1.1, 3.1). At f <= 1 the phase is the projector coordinate (1.8); above, it is known only up to
/// whole periods and there is no coordinate.
struct PhaseMeasuring {
  static constexpr std::string_view name = "pmp";

  int steps = 3;         ///< N, >= 3
  double frequency = 1;  ///< f, periods across the projector field, > 0
  Shifts shifts{};

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("steps", "frames of each sinusoid (N >= 3)", self.steps);
    visit("frequency", "periods across the projector field", self.frequency);
    visit_shifts(self.shifts, visit);
  }

  /// Throws Error for settings outside their ranges.
  void require_valid() const;
  /// Pattern n at projector coordinate y, in [0, 1].
  [[nodiscard]] double shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;
};

}  // namespace slipstream
