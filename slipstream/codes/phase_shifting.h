#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/codes/layout.h"
#include "slipstream/codes/sinusoid.h"

// Codings of phase-shifted sinusoids, one after the other or several in one frame. See Strategy for
// the members that all of them have.
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
  void require_valid() const;
  [[nodiscard]] double shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;
};

/// Two PMP scans in one: N_h frames at the high frequency f_h measure, N_l frames at the low
/// frequency f_l say which of the periods it is (multi-step temporal unwrapping, Liu 2010, Eq.
/// 1.17). High frames first.
struct DualFrequency {
  static constexpr std::string_view name = "dual-frequency";

  int steps = 3;                   ///< N_h, >= 3
  std::optional<int> low_steps{};  ///< N_l, >= 3; default: as many as `steps`
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
  void require_valid() const;
  [[nodiscard]] int low_step_count() const { return low_steps.value_or(steps); }
  [[nodiscard]] double shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;
};

/// Several PMP scans in one, each of any number of periods: Liu 2010, Eq. (1.17) from band to band,
/// beats of the bands (heterodyne), or all of them at once (the number-theoretical way).
struct MultiFrequency {
  static constexpr std::string_view name = "multi-frequency";

  std::vector<int> steps{3};              ///< N of each band, or of all
  std::vector<double> periods{1, 6, 36};  ///< of each band, in the order shown
  /// "hierarchical", "heterodyne" or "number-theory"; empty: the first of these whose fringe orders
  /// six standard deviations of the noise leave right, else the one that noise disturbs least.
  std::string unwrapping{};
  Shifts shifts{};

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("steps", "frames of each sinusoid (N >= 3)", self.steps);
    visit("periods", "across the projector field, of each sinusoid", self.periods);
    visit("unwrapping", "hierarchical, heterodyne or number-theory", self.unwrapping);
    visit_shifts(self.shifts, visit);
  }
  void require_valid() const;
  [[nodiscard]] double shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;

 private:
  [[nodiscard]] Sinusoid band(std::size_t i) const;
};

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
  void require_valid() const;
  [[nodiscard]] double shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;
};

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
  std::optional<int> carrier_steps{};  ///< M, >= 2; default: each sinusoid is shown alone
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
  void require_valid() const;
  [[nodiscard]] std::vector<ShownSinusoid> sinusoids() const;
};

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
