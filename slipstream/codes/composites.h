#pragma once

#include <limits>
#include <string_view>
#include <vector>

#include "slipstream/codes/composite.h"
#include "slipstream/codes/shift_settings.h"

// Codings that are said by which sinusoids each frame shows, and how far shifted.
namespace slipstream {

/// A sinusoid whose angles, in degrees, are those of the frames; NaN: not in the frame.
ShownSinusoid shown_in_frames(double periods, double share, const std::vector<double>& degrees,
                              const Shifts& shifts);

/// One sinusoid in a few frames: `Frames` says their name, and what each is shifted by.
template <class Frames>
struct OneSinusoid {
  static constexpr std::string_view name = Frames::name;

  double frequency = 1;  ///< periods across the field
  Shifts shifts{};

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("frequency", "periods across the projector field", self.frequency);
    visit_shifts(self.shifts, visit);
  }
  void require_valid() const {
    slipstream::require_valid(Sinusoid{.frequency = frequency}, Frames::name);
  }
  [[nodiscard]] std::vector<ShownSinusoid> sinusoids() const {
    return {shown_in_frames(frequency, 1, Frames::degrees(), shifts)};
  }
};

struct TwoPlusOneFrames {
  static constexpr const char* name = "two-plus-one";
  static std::vector<double> degrees() { return {90, 0, std::numeric_limits<double>::quiet_NaN()}; }
};
/// 2+1: a sine, a cosine and the mean (Wizinowich 1990; Zhang 2007). Where things move, two frames
/// alone must fall together.
using TwoPlusOne = OneSinusoid<TwoPlusOneFrames>;

struct FastThreeStepFrames {
  static constexpr const char* name = "fast-three-step";
  static std::vector<double> degrees() { return {120, 0, -120}; }
};
/// Three frames shifted by -120, 0 and 120 degrees, as fast three-step phase shifting shows them
/// (Huang and Zhang 2006). See PhaseMethod::intensity_ratio for its way to the phase.
using FastThreeStep = OneSinusoid<FastThreeStepFrames>;

struct DoubleThreeStepFrames {
  static constexpr const char* name = "double-three-step";
  static std::vector<double> degrees() { return {0, 120, 240, 60, 180, 300}; }
};
/// Two runs of three steps, the second 60 degrees after the first: the error that a response makes
/// twice in a period has opposite signs in both (Huang, Hu and Chiang 2002).
using DoubleThreeStep = OneSinusoid<DoubleThreeStepFrames>;

/// One period and N of them in one grating (Li, Su and Su 1997): 2 N frames, the grating moved by
/// parts of the long period, which leaves the short one where it is, and then by parts of the
/// short.
struct TwoFrequency2N {
  static constexpr std::string_view name = "two-frequency-2n";

  int steps = 5;       ///< N, 3 or more: frames of each group, and periods of the high frequency
  double share = 0.6;  ///< of the modulation for the high frequency
  Shifts shifts{};

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("steps", "frames of each sinusoid (N >= 3)", self.steps);
    visit("share", "of the modulation for the high frequency, the rest for the cue", self.share);
    visit_shifts(self.shifts, visit);
  }
  void require_valid() const;
  [[nodiscard]] std::vector<ShownSinusoid> sinusoids() const;
};

/// N sinusoids in all of 4 N frames, each shifted by quarters of its period in four of them (after
/// Kim et al. 1997).
struct TwoFrequency4N {
  static constexpr std::string_view name = "two-frequency-4n";

  std::vector<double> periods{1, 8};  ///< N of them, 2 or more
  Shifts shifts{};

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("periods", "across the projector field, of each sinusoid", self.periods);
    visit_shifts(self.shifts, visit);
  }
  void require_valid() const;
  [[nodiscard]] std::vector<ShownSinusoid> sinusoids() const;
};

}  // namespace slipstream
