#pragma once

#include <complex>

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

}  // namespace slipstream
