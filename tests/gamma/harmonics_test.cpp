#include "slipstream/gamma/harmonics.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "slipstream/gamma/distortion.h"

namespace slipstream {
namespace {

using std::numbers::pi;

/// Eqs. (4.9), (4.10), summed as printed for alpha alpha_p = 1.
double series_harmonic(double gamma, int k) {
  double b = 1;  // b_{k,0} = binomial(gamma, k) / 2^k
  for (int n = 0; n < k; ++n) b *= (gamma - n) / (n + 1) / 2;
  double sum = 0;
  for (int m = 0; m < 200000; ++m) {
    sum += b;
    b *= (2 * m + k - gamma) * (2 * m + k + 1 - gamma) / (4.0 * (m + 1) * (m + k + 1));  // (4.11)
  }
  return std::pow(0.5, gamma - 1) * sum;
}

TEST(Harmonics, AreTheSeriesAsPrinted) {
  for (const double gamma : {1.0, 1.5, 2.0, 2.21, 3.18, 5.0, 10.36}) {
    for (int k = 0; k <= 6; ++k) {
      EXPECT_NEAR(harmonic(gamma, k), series_harmonic(gamma, k), 1e-10) << gamma << ' ' << k;
    }
  }
}

TEST(Harmonics, VanishAboveAWholeGamma) {
  for (int gamma = 1; gamma <= 8; ++gamma) {
    EXPECT_GT(harmonic(gamma, gamma), 0);
    for (int k = gamma + 1; k < 12; ++k) EXPECT_EQ(harmonic(gamma, k), 0);
  }
}

TEST(Harmonics, AddUpToTheLight) {
  rc::check([] {
    const double gamma = *rc::gen::inRange(100, 1100) / 100.0;
    double all = harmonic(gamma, 0) / 2, odd = 0;
    double B = harmonic(gamma, 1);
    for (int k = 1; k < 20000; ++k) {
      all += B;
      if (k % 2 == 1) odd += B;
      B *= (gamma - k) / (gamma + k + 1);
    }
    RC_ASSERT(std::abs(all - 1) < 1e-7);      // (4.26)
    RC_ASSERT(std::abs(2 * odd - 1) < 1e-7);  // (4.27)
  });
}

TEST(HarmonicRatios, AreThoseOfTheResponsesFourierSeries) {
  for (const double gamma : {1.3, 2.2, 3.18, 7.73}) {
    const HarmonicRatios recurrence = harmonic_ratios(gamma, 8);
    const HarmonicRatios sampled = harmonic_ratios(Response(PowerLaw{gamma}), 8);
    for (std::size_t m = 0; m <= 8; ++m) EXPECT_NEAR(recurrence[m], sampled[m], 1e-9);
  }
}

TEST(HarmonicRatios, OfAMeasuredCurveAreNearThoseOfItsPowerLaw) {
  std::vector<double> values, intensities;
  for (int i = 0; i <= 32; ++i) {
    values.push_back(i / 32.0);
    intensities.push_back(std::pow(i / 32.0, 2.2));
  }
  const HarmonicRatios measured = harmonic_ratios(Response(response_curve(values, intensities)), 6);
  const HarmonicRatios exact = harmonic_ratios(2.2, 6);
  for (std::size_t m = 0; m <= 6; ++m) EXPECT_NEAR(measured[m], exact[m], 2e-5);
}

TEST(HighestHarmonic, KeepsTheWantedAccuracy) {
  for (const int steps : {3, 4, 5, 6, 9}) {
    for (const double gamma : {0.5, 0.8, 1.4, 2.21, 3.18, 4.42, 6.36, 10.36}) {
      for (const double accuracy : {1e-2, 1e-4}) {
        const int highest = highest_harmonic(gamma, steps, accuracy);
        const HarmonicRatios G = harmonic_ratios(gamma, highest);
        double worst = 0;
        for (int i = 0; i < 100; ++i) {
          const double phi = 2 * pi * i / (99.0 * steps);
          worst = std::max(worst, std::abs(phase_error(G, steps, phi) -
                                           phase_error(Response(PowerLaw{gamma}), steps, phi)));
        }
        EXPECT_LE(worst, accuracy) << "N " << steps << ", gamma " << gamma << ", M " << highest;
      }
    }
  }
}

TEST(HighestHarmonic, IsGammaWhereGammaIsWhole) {
  EXPECT_EQ(highest_harmonic(4, 3, 1e-9), 4);
}

}  // namespace
}  // namespace slipstream
