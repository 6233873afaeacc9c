#pragma once

#include <complex>
#include <cstdint>
#include <vector>

#include "slipstream/frame_set.h"
#include "slipstream/image.h"
#include "slipstream/response.h"

// Harmonics of the frames of one sinusoid, which show a response.
namespace slipstream {

/// Harmonics at one pixel, from the N frames of one sinusoid.
struct MeasuredHarmonics {
  double mean = 0;                   ///< distorted mean, Liu 2010, Eq. (4.31)
  std::complex<double> fundamental;  ///< C_N + i S_N, Eqs. (4.34), (4.35)
  /// C_{2,N} + i S_{2,N}, Eqs. (4.46), (4.47); for N = 4 the real B_cos (4.51); for N = 3 the
  /// mirrored fundamental, which adds no information.
  std::complex<double> second;
  std::complex<double> third;  ///< third harmonic; useful for N >= 6

  /// The modulation, Eq. (4.36): B_1 in Eq. (4.50).
  [[nodiscard]] double B_1() const { return std::abs(fundamental); }

  /// B_2 with its sign, which Eq. (4.50) loses: the component of the second harmonic in phase with
  /// the fundamental. Negative for gamma < 1.
  [[nodiscard]] double B_2() const {
    const double square = std::norm(fundamental);
    return square > 0 ? (second * std::conj(fundamental * fundamental)).real() / square : 0;
  }
};

/// Harmonics of every pixel, grey levels, from the `steps` frames that start at `first`.
Image<MeasuredHarmonics> pixel_harmonics(const FrameViews& frames, int first, int steps);

/// 1 where a pixel is usable for finding gamma: modulation of at least `minimum` grey levels and no
/// frame saturated. `minimum` <= 0: a sixteenth of the frames' full scale.
Image<std::uint8_t> well_lit(const Image<MeasuredHarmonics>& pixels, const FrameViews& frames,
                             double minimum = 0);

/// Harmonics that N frames measure under a response at true phase phi (rad) for alpha alpha_p = 1,
/// all harmonics included.
MeasuredHarmonics measured_harmonics(const Response& response, int steps, double phi);

/// Information of the harmonics about the response, equal for all pixels of the same measured
/// phase: independent of reflectivity and ambient light, except for N = 3.
struct Constraint {
  /// The second harmonic relative to the fundamental, Liu 2010, Eqs. (4.60), (4.61); for N = 3 the
  /// ratio of mean and modulation (4.58), which depends on ambient light.
  std::complex<double> second{};
  std::complex<double> third{};  ///< the third harmonic, relative; 0 for N < 6
  std::complex<double> mean{};   ///< A / B, which depends on ambient light
};

/// A pixel, or a point on a response's curve. Measured phase and constraint have period 2 pi / N.
struct HarmonicSample {
  double measured = 0;  ///< phase, rad, [0, 2 pi / N]
  Constraint constraint;
  double modulation = 1;  ///< grey levels: the constraint's noise is inversely proportional
};

/// The pixels where `lit` is 1, by increasing phase; a uniform subset if there are more than 40000.
std::vector<HarmonicSample> harmonic_samples(const Image<MeasuredHarmonics>& pixels,
                                             const Image<std::uint8_t>& lit, int steps);

/// Predictions of a response at each sample's measured phase, from its curve in `count` pieces.
std::vector<Constraint> predicted(const std::vector<HarmonicSample>& samples,
                                  const Response& response, int steps, int count = 16384);

/// Medians of samples in bins of the measured phase, insensitive to edges and noise.
struct ConstraintCurve {
  int steps = 0;
  std::vector<HarmonicSample> bins{};
  double variance = 0;  ///< of a bin's second and third harmonic, the mean of all bins
  double noise = 0;     ///< standard deviation of a pixel's harmonics
};

/// Skips bins with fewer than 10 samples. `near`: a response close to the samples', so that the bin
/// width has no effect.
ConstraintCurve constraint_curve(const std::vector<HarmonicSample>& samples, const Response& near,
                                 int steps);

/// Mean square residual of the second and third harmonic; infinite without bins.
double distance(const ConstraintCurve& curve, const Response& response);

/// The distance's root without noise: approximate phase error, rad, that correction leaves.
double misfit(const ConstraintCurve& curve, const Response& response);

/// Misfit that is hidden by the noise of one pixel, or negligible.
double harmless_misfit(const ConstraintCurve& curve);

/// RMS residual of mean over modulation, after fitting a uniform light: for N = 4 it indicates odd
/// harmonics, which distort the phase.
double misfit_of_mean(const ConstraintCurve& curve, const Response& response);

}  // namespace slipstream
