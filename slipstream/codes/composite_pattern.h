#pragma once

#include <string_view>
#include <vector>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/spectral_frame.h"

namespace slipstream {

/// One frame that holds the patterns of phase measuring, each as the strength of a carrier across
/// the axis (Guan, Hassebrook and Lau 2003), and with them a sinusoid of many periods along it,
/// which measures (Yue, Su and Liu 2007, Section 1.2): the one coding of one frame that gives a
/// projector coordinate by itself. See Demodulator.
struct CompositePattern {
  static constexpr std::string_view name = "composite";

  double high = 32;                          ///< f_h, periods of the sinusoid that measures
  double low = 1;                            ///< f_l, of those that the carriers hold
  std::vector<double> carriers{24, 40, 56};  ///< periods across the axis, one for each of N steps
  double share = 0.4;                        ///< of the modulation for the high frequency

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("high", "high frequency, periods across the field", self.high);
    visit("low", "low frequency, periods across the field", self.low);
    visit("carriers", "periods across the axis, one for each step", self.carriers);
    visit("share", "of the modulation for the high frequency, the rest for the cue", self.share);
  }

  /// Throws Error for settings outside their ranges.
  void require_valid() const;
  [[nodiscard]] double shape(int n, double y, double across) const;
  /// To the N patterns of the low frequency, and sine, cosine and mean of the high one.
  [[nodiscard]] Demodulation demodulation() const;
  [[nodiscard]] double read_shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;

 private:
  [[nodiscard]] int steps() const { return static_cast<int>(carriers.size()); }
};

}  // namespace slipstream
