#pragma once

#include <optional>
#include <string_view>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/shift_settings.h"

namespace slipstream {

/// Two PMP scans in one: N_h frames at the high frequency f_h measure, N_l frames at the low
/// frequency f_l say which of the periods it is (multi-step temporal unwrapping, Liu 2010, Eq.
/// 1.17). High frames first.
struct DualFrequency {
  static constexpr std::string_view name = "dual-frequency";

  int steps = 3;                   ///< N_h, >= 3
  std::optional<int> low_steps{};  ///< N_l, >= 3; the same as `steps` where not given
  double high = 16;  ///< f_h, a whole multiple of f_l, so that both ends of the field meet
  double low = 1;    ///< f_l, in (0, 1]
  Shifts shifts{};

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("steps", "frames of each sinusoid (N >= 3)", self.steps);
    visit("low_steps", "frames of the low frequency, where not as many", self.low_steps);
    visit("high", "periods of the high frequency across the field", self.high);
    visit("low", "periods of the low frequency", self.low);
    visit_shifts(self.shifts, visit);
  }

  /// Throws Error for settings outside their ranges.
  void require_valid() const;
  [[nodiscard]] int low_step_count() const { return low_steps.value_or(steps); }
  /// Pattern n at projector coordinate y, in [0, 1].
  [[nodiscard]] double shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;
};

}  // namespace slipstream
