#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "slipstream/response/distortion.h"

namespace slipstream::harmonics_test {

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

}  // namespace slipstream::harmonics_test
