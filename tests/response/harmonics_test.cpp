// The figures of Liu 2010, Sections 4.1 and 4.2, as recomputed from the equations.
#include "response/harmonics.h"

#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "paper/formulas.h"
#include "response/correction.h"
#include "response/gamma_calibration.h"

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

const Response gamma_318 = PowerLaw{3.18};

TEST(Harmonics, PhaseErrorHasTheRmsOfThePaperAtGamma318) {
  for (const auto& [steps, rms] :
       {std::pair{3, 0.30358}, {4, 0.05701}, {5, 0.0013962}, {6, 0.00013495}}) {
    EXPECT_NEAR(rms_phase_error(gamma_318, steps) / rms, 1, 5e-5) << steps;
  }
}

TEST(Harmonics, PhaseErrorIsEquation445WithAllHarmonics) {
  for (const int steps : {3, 4, 5, 6}) {
    const HarmonicRatios G = harmonic_ratios(3.18, 4000);
    for (double phi = 0; phi < 2 * pi; phi += 0.01) {
      EXPECT_NEAR(phase_error(G, steps, phi), phase_error(gamma_318, steps, phi), 1e-9);
    }
  }
}

TEST(Harmonics, PhaseErrorVanishesAtMultiplesOfPiOverNAllAround) {
  for (int steps = 3; steps <= 6; ++steps) {
    for (int n = 0; n < 2 * steps; ++n) {
      EXPECT_NEAR(phase_error(gamma_318, steps, pi * n / steps), 0, 1e-14);
    }
  }
}

TEST(Harmonics, PhaseErrorVanishesWhereTheHarmonicsDo) {
  // Fig. 4.6: gamma whole and at most N - 2.
  for (int steps = 3; steps <= 8; ++steps) {
    for (int gamma = 1; gamma <= steps - 2; ++gamma) {
      EXPECT_LT(rms_phase_error(PowerLaw{double(gamma)}, steps), 1e-14);
    }
    EXPECT_GT(rms_phase_error(PowerLaw{double(steps - 1)}, steps), 1e-6);
  }
}

TEST(Harmonics, MisfitOfTheMeanAllowsForAUniformLight) {
  const Response law = PowerLaw{1.8};
  ConstraintCurve curve{.steps = 4};
  for (int i = 1; i < 20; ++i) {
    const double phi = i * pi / 2 / 20, modulation = 40 + 2 * i, ambient = 10;
    const MeasuredHarmonics seen = measured_harmonics(law, 4, phi);
    curve.bins.push_back({.measured = std::arg(seen.fundamental),
                          .constraint = {.mean = seen.mean / seen.B_1() + ambient / modulation},
                          .modulation = modulation});
  }
  EXPECT_LT(misfit_of_mean(curve, law), 1e-4);
  EXPECT_GT(misfit_of_mean(curve, PowerLaw{1}), 1e-3);
}

TEST(Harmonics, WellLitPixelsAreNeverSaturated) {
  FrameSet::Images8 images(3, Image<std::uint8_t>({2, 1}, 100));
  images[0](0, 0) = 255;
  images[0](1, 0) = 250;
  const FrameSet frames(images);
  const Image<std::uint8_t> lit = well_lit(pixel_harmonics(frames, 0, 3), frames);
  EXPECT_EQ(lit(0, 0), 0);
  EXPECT_EQ(lit(1, 0), 1);
}

TEST(Harmonics, TruePhaseHasTheErrorsOfTable41) {
  // Two digits of the print; more of them as recomputed.
  for (const auto& [highest, rms] :
       {std::pair{2, 4.008e-3}, {4, 3.673e-4}, {5, 2.870e-5}, {7, 6.240e-6}, {8, 1.824e-6}}) {
    const HarmonicRatios G = harmonic_ratios(3.18, highest);
    double sum = 0;
    constexpr int samples = 2000;
    for (int i = 0; i < samples; ++i) {
      const double phi = 2 * pi * i / samples;
      const double error = true_phase(G, 3, distorted_phase(gamma_318, 3, phi)) - phi;
      sum += error * error;
    }
    EXPECT_NEAR(std::sqrt(sum / samples) / rms, 1, 2e-3) << highest;
  }
}

TEST(Harmonics, GammaFromHarmonicsHasTheErrorsOfFigure47) {
  for (const auto& [steps, rms] : {std::pair{5, 0.518},
                                   {6, 1.33e-2},
                                   {7, 1.40e-3},
                                   {8, 2.9e-4},
                                   {10, 3.0e-5},
                                   {12, 5.6e-6},
                                   {16, 4.9e-7},
                                   {20, 8.1e-8}}) {
    double sum = 0;
    constexpr int samples = 5000;
    for (int i = 0; i < samples; ++i) {
      const MeasuredHarmonics measured = measured_harmonics(gamma_318, steps, 2 * pi * i / samples);
      const double gamma =
          gamma_from_harmonics(std::abs(measured.fundamental), std::abs(measured.second));
      sum += (gamma - 3.18) * (gamma - 3.18);
    }
    EXPECT_NEAR(std::sqrt(sum / samples) / rms, 1, 0.05) << steps;
  }
}

TEST(Harmonics, MeasuredHarmonicsSayWhenGammaIsBelow1) {
  const MeasuredHarmonics measured = measured_harmonics(PowerLaw{0.7}, 24, 1.0);
  EXPECT_NEAR(gamma_from_harmonics(measured.B_1(), measured.B_2()), 0.7, 1e-2);
  EXPECT_LT(measured.B_2(), 0);
}

}  // namespace slipstream::harmonics_test
