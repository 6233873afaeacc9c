#pragma once

#include <optional>
#include <string_view>

#include "slipstream/capture/frame_set.h"
#include "slipstream/phase/phase_decoder.h"
#include "slipstream/strategy/cue_settings.h"
#include "slipstream/strategy/decoded_scan.h"

namespace slipstream {

/// Two PMP scans in one: N_h frames at the high frequency f_h measure, N_l frames at the low
/// frequency f_l say which of the periods it is (multi-step temporal unwrapping, Liu 2010, Eq.
/// 1.17). High frames first.
struct DualFrequency {
  static constexpr std::string_view name = "dual-frequency";

  int steps = 3;                 ///< N_h, >= 3
  std::optional<int> low_steps;  ///< N_l, >= 3; the same as `steps` where not given
  double high = 16;  ///< f_h, a whole multiple of f_l, so that both ends of the field meet
  double low = 1;    ///< f_l, in (0, 1]

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("steps", "frames of each sinusoid (N >= 3)", self.steps);
    visit("low_steps", "frames of the low frequency, where not as many", self.low_steps);
    visit("high", "periods of the high frequency across the field", self.high);
    visit("low", "periods of the low frequency, at most 1", self.low);
  }

  /// Throws Error for settings outside their ranges.
  void require_valid() const;
  [[nodiscard]] int low_step_count() const { return low_steps.value_or(steps); }
  [[nodiscard]] int frame_count() const { return steps + low_step_count(); }
  [[nodiscard]] std::vector<int> step_counts() const { return {steps, low_step_count()}; }
  [[nodiscard]] static bool has_coordinate() { return true; }
  [[nodiscard]] double highest_frequency() const { return high; }
  /// Pattern n at projector coordinate y, in [0, 1].
  [[nodiscard]] double shape(int n, double y) const;
  /// `length`: projector pixels along the axis.
  [[nodiscard]] DecodedScan decode(const FrameSet& frames, const PhaseDecoder& phase, int length,
                                   const CueSettings& cue) const;
  /// B^c over alpha alpha_p / 2, by which noise is judged from the modulation.
  [[nodiscard]] static double modulation_share() { return 1; }
  /// Predicted variance of y, Eq. (3.40) at f_h, where the fringe order is right.
  [[nodiscard]] double coordinate_variance(double alpha, double alpha_p,
                                           double noise_variance) const;
};

}  // namespace slipstream
