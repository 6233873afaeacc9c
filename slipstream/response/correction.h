#pragma once

#include <complex>
#include <functional>
#include <span>
#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/codes/pattern_set.h"
#include "slipstream/codes/response.h"
#include "slipstream/decode/phase_decoder.h"
#include "slipstream/frames/frame_set.h"

namespace slipstream {

/// What N frames of one sinusoid say about the harmonics at one place.
struct MeasuredHarmonics {
  double mean = 0;                   ///< distorted mean, Liu 2010, Eq. (4.31)
  std::complex<double> fundamental;  ///< C_N + i S_N, Eqs. (4.34), (4.35)
  /// C_{2,N} + i S_{2,N}, Eqs. (4.46), (4.47); for N = 4 the real B_cos (4.51); for N = 3 the
  /// fundamental mirrored, which says nothing more.
  std::complex<double> second;
  std::complex<double> third;  ///< the same of the third harmonic; of use for N >= 6

  /// The modulation, Eq. (4.36): B_1 as Eq. (4.50) takes it.
  [[nodiscard]] double B_1() const { return std::abs(fundamental); }
  /// B_2 with its sign, which Eq. (4.50) loses: the part of the second harmonic in step with the
  /// fundamental. Negative where gamma < 1.
  [[nodiscard]] double B_2() const {
    const double square = std::norm(fundamental);
    return square > 0 ? (second * std::conj(fundamental * fundamental)).real() / square : 0;
  }
};

/// Of the `steps` frames that start at `first`, every pixel, in grey levels.
Image<MeasuredHarmonics> pixel_harmonics(const FrameViews& frames, int first, int steps);

/// 1 where a pixel serves to find gamma: modulation of at least `minimum` grey levels and none of
/// the frames saturated. `minimum` 0 or less: a sixteenth of the frames' full scale.
Image<std::uint8_t> well_lit(const Image<MeasuredHarmonics>& pixels, const FrameViews& frames,
                             double minimum = 0);

/// What N frames of a response measure at true phase phi (rad) for alpha alpha_p = 1, all harmonics
/// included.
MeasuredHarmonics measured_harmonics(const Response& response, int steps, double phi);

/// The phase that N steps measure, Eq. (4.42), all harmonics included: within a third of a turn
/// of phi, not wrapped. phi in rad.
double distorted_phase(const Response& response, int steps, double phi);

/// Delta phi = phi - distorted phase, Eq. (4.45), rad.
double phase_error(const Response& response, int steps, double phi);

/// What the harmonics say of the response, the same at every pixel of one measured phase:
/// reflectivity and ambient light are not in it, but for N = 3.
struct Constraint {
  /// The second harmonic relative to the fundamental, Liu 2010, Eqs. (4.60), (4.61); for N = 3 the
  /// ratio of mean and modulation (4.58), which ambient light changes.
  std::complex<double> second{};
  std::complex<double> third{};  ///< the third, likewise; 0 for N < 6, which say nothing of it
  std::complex<double> mean{};   ///< A / B, to which ambient light adds
};

/// A pixel, or a place on a response's curve. Measured phase and constraint repeat with 2 pi / N.
struct HarmonicSample {
  double measured = 0;  ///< phase, rad, [0, 2 pi / N]
  Constraint constraint;
  double modulation = 1;  ///< grey levels: the noise of the constraint goes with its inverse
};

/// The pixels where `lit` is 1, by rising phase; evenly chosen ones where they are more than 40000.
std::vector<HarmonicSample> harmonic_samples(const Image<MeasuredHarmonics>& pixels,
                                             const Image<std::uint8_t>& lit, int steps);

/// What a response predicts at each sample's measured phase, by its curve in `count` pieces.
std::vector<Constraint> predicted(const std::vector<HarmonicSample>& samples,
                                  const Response& response, int steps, int count = 16384);

/// The medians of samples in bins of the measured phase, by which edges and noise do not count.
struct ConstraintCurve {
  int steps = 0;
  std::vector<HarmonicSample> bins{};
  double variance = 0;  ///< of a bin's second and third harmonic, the mean of all bins
  double noise = 0;     ///< standard deviation of those of a pixel
};

/// Bins of less than 10 samples are left out. `near`: a response not far from that of the samples,
/// so that a bin's width does not count.
ConstraintCurve constraint_curve(const std::vector<HarmonicSample>& samples, const Response& near,
                                 int steps);

/// Mean square of what the response leaves of the second and third harmonic; infinite where there
/// are no bins.
double distance(const ConstraintCurve& curve, const Response& response);

/// Its root, less what noise does: about the phase error in rad that correcting by it leaves.
double misfit(const ConstraintCurve& curve, const Response& response);

/// How much of it drowns in the noise of one pixel, or is too little to matter.
double harmless_misfit(const ConstraintCurve& curve);

/// RMS of what the response leaves of the mean over the modulation, once light that is the same
/// everywhere is taken away: what N = 4 say of odd harmonics, which bend their phase.
double misfit_of_mean(const ConstraintCurve& curve, const Response& response);

/// The true phase behind a measured one, Liu 2010, Eqs. (4.56), (4.57): solves the distorted phase
/// (4.42) for phi to rounding. `measured` in rad, any; N >= 3.
double true_phase(const Response& response, int steps, double measured);

/// The same by any `distorted(phi)` that agrees with phi at the multiples of pi / N and rises.
double true_phase(const std::function<double(double)>& distorted, int steps, double measured);

/// What correcting multiplies the noise of a measured phase by, at true phase phi, rad: more than 1
/// where the response presses phases together. N >= 3.
double noise_gain(const Response& response, int steps, double phi);

/// What is added to the measured phase, as a table: made once for a device. Its length is the
/// power of two, 256 to 65536, at which linear interpolation is within `accuracy` (rad); past gamma
/// 4.5, N = 3 needs more than that where the measured phase hardly moves, and is less accurate
/// there. Throws Error where N < 3 or gamma is out of range.
PhaseCorrection phase_correction(const Response& response, int steps, double accuracy = 2e-7);

/// One for each of the step counts.
PhaseCorrections phase_corrections(const Response& response, std::span<const int> step_counts);

/// The pictures that a projector of that response turns into the light of `patterns`: the inverse
/// response is applied before projection. What people do instead of correcting the phase; it costs
/// grey levels, because the pictures are rounded to the projector's after it.
PatternSet precompensated(const PatternSet& patterns, const Response& response);

}  // namespace slipstream
