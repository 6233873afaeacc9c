#pragma once

#include <functional>
#include <optional>
#include <string_view>

#include "slipstream/phase_shifting.h"

namespace slipstream {

/// Phase channel multiplexing, PCMP (Liu 2010, Section 3.2): a sinusoid of f_h periods measures,
/// and a cue in a free channel of the same N frames gives the period. N = 3: a monotonic reference
/// R in the DC channel (3.53), which requires the ambient light; N = 4: R in the half phase channel
/// (3.68); N >= 5: a sinusoid of one period in the second phase channel (3.83).
struct PhaseChannelMultiplexing {
  static constexpr std::string_view name = "pcmp";

  int steps = 5;                  ///< N, >= 3
  std::optional<double> high{};   ///< f_h, whole, >= 2; default 3, 6, 12 for N = 3, 4, >= 5
  std::optional<double> share{};  ///< c_1, in (1 / f_h, 1); default 0.5, 0.6, 0.6; c_2 = 1 - c_1
  /// R for N = 3 and 4: monotonic, within [-1, 1], for y in [0, 1]; default 2 y - 1 and cos(pi y).
  /// Files and command lines cannot specify others.
  std::function<double(double y)> reference{};
  Shifts shifts{};  ///< non-default ones require the reference engine

  static void for_each_setting(auto& self, const auto& visit) {
    visit("steps", "frames per sinusoid (N >= 3)", self.steps);
    visit("high", "high frequency, periods across the field", self.high);
    visit("share", "modulation share of the high frequency; the cue gets the rest", self.share);
    visit_shifts(self.shifts, visit);
  }

  /// Throws Error for settings out of range, or beyond Eq. (3.64), where unit-frequency PMP is as
  /// good.
  void require_valid() const;

  [[nodiscard]] double f_h() const { return high.value_or(steps == 3 ? 3 : steps == 4 ? 6 : 12); }
  [[nodiscard]] double c1() const { return share.value_or(steps == 3 ? 0.5 : 0.6); }
  [[nodiscard]] double c2() const { return 1 - c1(); }

  /// Reference of the cue for N = 3 and 4.
  [[nodiscard]] CueReference cue_reference() const;

  [[nodiscard]] double shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;
};

/// Period coded phase shifting: sinusoids of full modulation, with a cue for the period in the
/// headroom of the same frames. It has the aim of Wang, Liu, Hao, Lau and Hassebrook (IEEE TIP
/// 20(11), 2011), whose formula is not in public text; the construction is our own. Frame n and the
/// one half a period later are both made brighter or darker by
///   r c_2 / a(phi) sign(g_n) (1 - |cos(phi - 2 pi n / N)|), g_n = cos(4 pi n / N), r = 2 y - 1
/// of the modulation, a(phi) = sum |g_n| (1 - |cos|) / sum g_n^2. This cancels in Eqs. (1.5),
/// (1.6), and the second channel reads it as c_2 r, c_2 = 1 - 1 / sqrt(2).
struct PeriodCoded {
  static constexpr std::string_view name = "pcps";

  int steps = 4;     ///< N, even, 4 or more
  double high = 12;  ///< f, whole
  Shifts shifts{};

  static void for_each_setting(auto& self, const auto& visit) {
    visit("steps", "frames per sinusoid (N >= 3)", self.steps);
    visit("high", "high frequency, periods across the field", self.high);
    visit_shifts(self.shifts, visit);
  }

  void require_valid() const;
  [[nodiscard]] double shape(int n, double y) const;

  /// The mean includes the cue's light.
  [[nodiscard]] Layout layout() const;
};

}  // namespace slipstream
