#pragma once

#include <complex>
#include <cstdint>
#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/codes/response.h"
#include "slipstream/response/measured_harmonics.h"

namespace slipstream {

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

}  // namespace slipstream
