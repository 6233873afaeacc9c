#pragma once

#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/layout.h"

// Codings of phase-shifted sinusoids, in sequence or several in one frame. See Strategy.
namespace slipstream {

/// N phase-shifted patterns (`steps`) of f periods across the projector field (`frequency`).
struct Sinusoid {
  int steps = 3;
  double frequency = 1;
  Shifts shifts{};
  std::vector<double> angles{};  ///< shift of each pattern, degrees; empty: 360 n / N

  [[nodiscard]] int frames() const {
    return angles.empty() ? steps : static_cast<int>(angles.size());
  }
};

/// More frames than this for one sinusoid are a mistake in a settings file.
inline constexpr int most_steps = 4096;

/// Intensity of pattern n at y, in [0, 1]: the bracket of Liu 2010, Eq. (3.1), 1/2 + 1/2 cos(2 pi f
/// y - 2 pi n / N), with the phase modified by Shifts, or with the given angle in place of 2 pi n /
/// N; Eq. (1.1) up to scale if A^p = B^p.
double sinusoid_intensity(const Sinusoid& sinusoid, int n, double y);

/// Intensity of pattern n of consecutive runs, and the layout of their frames.
double intensity_of(const std::vector<Sinusoid>& runs, int n, double y);
Layout layout_of(const std::vector<Sinusoid>& runs, Unwrapping unwrapping);

/// Throws Error, beginning with `name`, unless 3 <= steps <= most_steps, frequency is finite and
/// positive, and three of the angles, if given, differ by a degree or more, modulo 360.
void require_valid(const Sinusoid& sinusoid, const char* name);

/// Its first phase channel, in frames from `first` on out of `frames`. Given angles have the
/// weights of least squares of mean, cosine and sine, which have the least noise.
Band band_of(const Sinusoid& sinusoid, int frames, int first = 0, double share = 1);

/// Settings shared by all codings of sinusoids, for patterns made elsewhere: see Strategy.
void visit_shifts(auto& shifts, const auto& visit) {
  visit("origin", "phase of the first frame at the edge of the field, rad", shifts.origin);
  visit("backwards", "reverse the phase shifts from frame to frame", shifts.backwards);
}

/// The frames of a sinusoid: `angles`, or `steps` without them.
void visit_steps(auto& coding, const auto& visit) {
  if (coding.angles.empty()) visit("steps", "frames per sinusoid (N >= 3)", coding.steps);
  visit("shifts", "in place of steps: shift of each frame, degrees, e.g. 0,90,180,270",
        coding.angles);
}

/// A sinusoid in the frames, alone or multiplexed with others.
struct ShownSinusoid {
  double periods = 1;
  double share = 1;             ///< of the modulation; all shares sum to at most 1
  double carrier = 0;           ///< periods across the axis
  std::vector<double> angle{};  ///< rad, in each frame: cos(2 pi (f y + carrier x) - angle)
  std::vector<bool> shown{};    ///< whether the frame contains it
};

/// The sinusoid with shifts applied: angle - origin, or - angle - origin if backwards.
ShownSinusoid turned(ShownSinusoid sinusoid, const Shifts& shifts);

/// Intensity of frame n at y and `across`, in [0, 1]: 1/2 plus half of each sinusoid.
double composite_intensity(const std::vector<ShownSinusoid>& sinusoids, int n, double y,
                           double across = 0);

/// Weights of least noise that extract each sinusoid's C and S and the mean from frames that show
/// them together: the pseudo-inverse of the frames' matrix. A sinusoid with a carrier and the next
/// one, its mirror image with negative carrier, form one band: see Band::carrier. Throws Error,
/// beginning with `name`, if the frames cannot separate them.
std::vector<Band> fitted_bands(const std::vector<ShownSinusoid>& sinusoids, std::string_view name);

/// Phase measuring profilometry, PMP: N phase-shifted sinusoids of frequency f (Liu 2010, Eqs. 1.1,
/// 3.1). For f <= 1 the phase gives the coordinate (1.8); above, it is ambiguous by whole periods.
struct PhaseMeasuring {
  static constexpr std::string_view name = "pmp";

  int steps = 3;         ///< N, >= 3
  double frequency = 1;  ///< f, periods across the projector field, > 0
  Shifts shifts{};
  std::vector<double> angles{};  ///< degrees; replace `steps`: see Sinusoid

  static void for_each_setting(auto& self, const auto& visit) {
    visit_steps(self, visit);
    visit("frequency", "periods across the projector field", self.frequency);
    visit_shifts(self.shifts, visit);
  }

  void require_valid() const { slipstream::require_valid(runs().front(), "pmp"); }
  [[nodiscard]] std::vector<Sinusoid> runs() const { return {{steps, frequency, shifts, angles}}; }
  [[nodiscard]] Layout layout() const { return layout_of(runs(), Unwrapping::none); }
};

/// Two PMP scans in one: N_h frames of high frequency f_h measure, N_l of low frequency f_l give
/// the period (Liu 2010, Eq. 1.17). High frames first.
struct DualFrequency {
  static constexpr std::string_view name = "dual-frequency";

  int steps = 3;                   ///< N_h, >= 3
  std::optional<int> low_steps{};  ///< N_l, >= 3; default: `steps`
  double high = 16;  ///< f_h, a whole multiple of f_l, so that both ends of the field meet
  double low = 1;    ///< f_l, in (0, 1]
  Shifts shifts{};
  std::vector<double> angles{};  ///< degrees; replace `steps`: see Sinusoid

  static void for_each_setting(auto& self, const auto& visit) {
    visit_steps(self, visit);
    if (self.angles.empty())
      visit("low_steps", "frames of the low frequency; default: as steps", self.low_steps);
    visit("high", "high frequency, periods across the field", self.high);
    visit("low", "low frequency, periods across the field", self.low);
    visit_shifts(self.shifts, visit);
  }

  void require_valid() const;
  [[nodiscard]] std::vector<Sinusoid> runs() const {
    return {{steps, high, shifts, angles}, {low_steps.value_or(steps), low, shifts, angles}};
  }
  [[nodiscard]] Layout layout() const { return layout_of(runs(), Unwrapping::hierarchical); }
};

/// Several PMP scans in one, of any periods: unwrapped from band to band (Liu 2010, Eq. 1.17), by
/// beats (heterodyne) or from all bands at once (number-theoretical).
struct MultiFrequency {
  static constexpr std::string_view name = "multi-frequency";

  std::vector<int> steps{3};              ///< N of each band, or one N for all
  std::vector<double> periods{1, 6, 36};  ///< of each band, in display order
  /// "hierarchical", "heterodyne" or "number-theory"; empty: the first of these that is correct at
  /// six standard deviations of the noise, otherwise the most robust.
  std::string unwrapping{};
  Shifts shifts{};
  std::vector<double> angles{};  ///< degrees; replace `steps`: see Sinusoid

  static void for_each_setting(auto& self, const auto& visit) {
    visit_steps(self, visit);
    visit("periods", "periods of each sinusoid across the field", self.periods);
    visit("unwrapping", "hierarchical, heterodyne or number-theory; default: automatic",
          self.unwrapping);
    visit_shifts(self.shifts, visit);
  }

  void require_valid() const;
  [[nodiscard]] std::vector<Sinusoid> runs() const;
  [[nodiscard]] Layout layout() const;
};

/// Micro phase shifting (Gupta and Nayar, CVPR 2012): sinusoids of many, slightly different
/// periods, three steps of the first and one frame of each other. Interreflections and subsurface
/// scattering average out over such narrow fringes equally in all frames.
struct MicroPhaseShifting {
  static constexpr std::string_view name = "micro";

  std::vector<double> periods{64, 61, 59, 57, 53};  ///< of the steps, then of each further frame
  bool alternating = false;  ///< inverts the further frames 0, 2, 4, ..., as SLStudio does
  Shifts shifts{};

  static void for_each_setting(auto& self, const auto& visit) {
    visit("periods", "periods of each sinusoid across the field", self.periods);
    visit("alternating", "invert every second single frame, from the first on", self.alternating);
    visit_shifts(self.shifts, visit);
  }

  void require_valid() const;
  [[nodiscard]] double shape(int n, double y) const;
  [[nodiscard]] Layout layout() const;
};

/// Modulated phase shifting (after Chen, Seidel and Lensch, CVPR 2008): a base along the axis times
/// a carrier across it, 1/2 + 1/2 cos(pi f y - 2 pi n / N) cos(2 pi c x - pi m / M), M shifts of
/// the carrier for each of the N of the base. The product is a sum of two oblique sinusoids, of pi
/// f y + 2 pi c x and pi f y - 2 pi c x; shown in sequence, N steps each at full modulation, they
/// have half the variance of the same number of frames of both. Interreflections and subsurface
/// scattering mix many periods of the carrier: they change the mean and not the phase.
struct ModulatedPhaseShifting {
  static constexpr std::string_view name = "modulated";

  int steps = 3;                       ///< N, >= 3
  std::optional<int> carrier_steps{};  ///< M, >= 2; default: each sinusoid is shown alone
  std::vector<double> periods{1, 16};  ///< f of the bases' brightness; each sinusoid has half of it
  double carrier = 64;                 ///< c, periods along the other axis
  Shifts shifts{};

  static void for_each_setting(auto& self, const auto& visit) {
    visit("steps", "frames per sinusoid (N >= 3)", self.steps);
    visit("carrier_steps", "carrier shifts for each base shift; default: oblique sinusoids",
          self.carrier_steps);
    visit("periods", "periods of each sinusoid across the field", self.periods);
    visit("carrier", "periods of the carrier along the other axis", self.carrier);
    visit_shifts(self.shifts, visit);
  }

  void require_valid() const;
  [[nodiscard]] std::vector<ShownSinusoid> sinusoids() const;
};

/// A sinusoid with the given angle in each frame, degrees; NaN: not in that frame.
ShownSinusoid shown_in_frames(double periods, double share, const std::vector<double>& degrees,
                              const Shifts& shifts);

/// One sinusoid in a few frames; `Frames` has its name and the shift of each frame.
template <class Frames>
struct OneSinusoid {
  static constexpr std::string_view name = Frames::name;

  double frequency = 1;  ///< periods across the field
  Shifts shifts{};

  static void for_each_setting(auto& self, const auto& visit) {
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

/// 2+1: sine, cosine and mean (Wizinowich 1990; Zhang 2007). Only motion between two frames
/// matters.
using TwoPlusOne = OneSinusoid<TwoPlusOneFrames>;

struct FastThreeStepFrames {
  static constexpr const char* name = "fast-three-step";
  static std::vector<double> degrees() { return {120, 0, -120}; }
};

/// Shifts of -120, 0 and 120 degrees, as in fast three-step phase shifting (Huang and Zhang 2006):
/// see PhaseMethod::intensity_ratio.
using FastThreeStep = OneSinusoid<FastThreeStepFrames>;

struct DoubleThreeStepFrames {
  static constexpr const char* name = "double-three-step";
  static std::vector<double> degrees() { return {0, 120, 240, 60, 180, 300}; }
};
/// Two runs of three steps, 60 degrees apart: the response error at twice the frequency has
/// opposite signs in them (Huang, Hu and Chiang 2002).
using DoubleThreeStep = OneSinusoid<DoubleThreeStepFrames>;

/// One period and N periods in one grating (Li, Su and Su 1997): N frames shifted by N-ths of the
/// long period, which are whole short periods, then N by N-ths of the short one.
struct TwoFrequency2N {
  static constexpr std::string_view name = "two-frequency-2n";

  int steps = 5;       ///< N, >= 3: frames per group, and periods of the high frequency
  double share = 0.6;  ///< share of the modulation for the high frequency
  Shifts shifts{};

  static void for_each_setting(auto& self, const auto& visit) {
    visit("steps", "frames per sinusoid (N >= 3)", self.steps);
    visit("share", "modulation share of the high frequency; the cue gets the rest", self.share);
    visit_shifts(self.shifts, visit);
  }

  void require_valid() const;
  [[nodiscard]] std::vector<ShownSinusoid> sinusoids() const;
};

/// N sinusoids in all of 4 N frames, each shifted by quarters of its period in four of them (after
/// Kim et al. 1997).
struct TwoFrequency4N {
  static constexpr std::string_view name = "two-frequency-4n";

  std::vector<double> periods{1, 8};  ///< N >= 2 of them
  Shifts shifts{};

  static void for_each_setting(auto& self, const auto& visit) {
    visit("periods", "periods of each sinusoid across the field", self.periods);
    visit_shifts(self.shifts, visit);
  }

  void require_valid() const;
  [[nodiscard]] std::vector<ShownSinusoid> sinusoids() const;
};

}  // namespace slipstream
