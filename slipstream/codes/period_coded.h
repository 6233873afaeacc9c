#pragma once

#include <string_view>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/shift_settings.h"

namespace slipstream {

/// Period coded phase shifting: sinusoids of full modulation, and in the same frames, where they
/// leave room, a cue that says which period it is. The aim is that of Wang, Liu, Hao, Lau and
/// Hassebrook (IEEE TIP 20(11), 2011), whose formula is not in public text; the construction is our
/// own. Frame n and the one half a period later are both made brighter or darker by
///   r(y) c_2 / a(phi) sign(g_n) (1 - |cos(phi - 2 pi n / N)|),  g_n = cos(4 pi n / N),  r = 2 y -
///   1
/// of the modulation, a(phi) = sum |g_n| (1 - |cos|) / sum g_n^2, which no sum of Eqs. (1.5), (1.6)
/// sees, and which the second channel reads as c_2 r(y), c_2 = 1 - 1 / sqrt(2).
struct PeriodCoded {
  static constexpr std::string_view name = "pcps";

  int steps = 4;     ///< N, even, 4 or more
  double high = 12;  ///< f, whole
  Shifts shifts{};

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("steps", "frames of each sinusoid (N >= 3)", self.steps);
    visit("high", "periods of the high frequency across the field", self.high);
    visit_shifts(self.shifts, visit);
  }

  /// Throws Error for settings outside their ranges.
  void require_valid() const;
  /// Pattern n at projector coordinate y, in [0, 1].
  [[nodiscard]] double shape(int n, double y) const;
  /// Its mean is that of the frames, the cue's light in it.
  [[nodiscard]] Layout layout() const;
};

}  // namespace slipstream
