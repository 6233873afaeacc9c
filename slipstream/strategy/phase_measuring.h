#pragma once

#include <string_view>

#include "slipstream/capture/frame_set.h"
#include "slipstream/phase/phase_decoder.h"
#include "slipstream/strategy/cue_settings.h"
#include "slipstream/strategy/decoded_scan.h"

namespace slipstream {

/// Phase measuring profilometry, PMP: N phase-shifted sinusoids of one frequency f (Liu 2010, Eqs.
/// 1.1, 3.1). At f <= 1 the phase is the projector coordinate (1.8); above, it is known only up to
/// whole periods and there is no coordinate.
struct PhaseMeasuring {
  static constexpr std::string_view name = "pmp";

  int steps = 3;         ///< N, >= 3
  double frequency = 1;  ///< f, periods across the projector field, > 0

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("steps", "frames of each sinusoid (N >= 3)", self.steps);
    visit("frequency", "periods across the projector field", self.frequency);
  }

  /// Throws Error for settings outside their ranges.
  void require_valid() const;
  [[nodiscard]] int frame_count() const { return steps; }
  [[nodiscard]] std::vector<int> step_counts() const { return {steps}; }
  [[nodiscard]] bool has_coordinate() const { return frequency <= 1; }
  [[nodiscard]] double highest_frequency() const { return frequency; }
  /// Pattern n at projector coordinate y, in [0, 1].
  [[nodiscard]] double shape(int n, double y) const;
  /// `length`: projector pixels along the axis.
  [[nodiscard]] DecodedScan decode(const FrameSet& frames, const PhaseDecoder& phase, int length,
                                   const CueSettings& cue) const;
  /// B^c over alpha alpha_p / 2, by which noise is judged from the modulation.
  [[nodiscard]] static double modulation_share() { return 1; }
  /// Predicted variance of y, Eq. (3.40): see phase_variance.
  [[nodiscard]] double coordinate_variance(double alpha, double alpha_p,
                                           double noise_variance) const;
};

}  // namespace slipstream
