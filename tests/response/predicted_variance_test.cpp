// Predictions of Liu 2010, Chapter 3, as printed and against a great many noisy pixels.
#include "codes/predicted_variance.h"

#include <cmath>
#include <numbers>
#include <random>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "decode/equations.h"
#include "paper/formulas.h"
#include "slipstream/strategy.h"

namespace slipstream::predicted_variance_test {

using std::numbers::pi;

constexpr PatternLight light{.alpha_p = 200, .beta_p = 55};
constexpr double ambient = -7;
constexpr double sigma_w2 = 1.6;
constexpr int trials = 60000;

struct Moments {
  double sum = 0, squares = 0, count = 0;
  void add(double x) {
    sum += x;
    squares += x * x;
    ++count;
  }
  [[nodiscard]] double mean() const { return sum / count; }
  [[nodiscard]] double variance() const { return squares / count - mean() * mean(); }
};

/// Calls `visit` with the noisy intensities of a pixel, (3.2) and (3.10), again and again; `s`
/// gives the bracket of Eq. (3.1).
template <class Shape, class Visit>
void for_each_noisy_pixel(int steps, double alpha, const Shape& s, const Visit& visit) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> w(0, std::sqrt(sigma_w2));
  std::vector<double> I(static_cast<std::size_t>(steps));
  for (int trial = 0; trial < trials; ++trial) {
    for (int n = 0; n < steps; ++n) {
      I[static_cast<std::size_t>(n)] =
          alpha * (light.alpha_p * s(n) + light.beta_p + ambient) + ambient + w(random);
    }
    visit(std::span<const double>(I));
  }
}

/// Of the ambient light: Eq. (3.42).
double ambient_variance(int steps, double alpha) {
  const double lift = 1 + 2 * (light.beta_p + ambient) / light.alpha_p;
  return (2 * lift * lift + 1) * sigma_w2 / (steps * (alpha + 1) * (alpha + 1));
}

/// Of y by N-step PCMP: Eq. (3.63), written for any N; `share` is c_1.
double multiplexed_coordinate_variance(int steps, double alpha, double share, double frequency,
                                       double noise_variance) {
  return coordinate_variance(phase_variance(steps, share * alpha, light.alpha_p, noise_variance),
                             frequency);
}

/// Uneven shifts: the mean over all phases.
TEST(PredictedVariance, OfShiftsByLeastSquares) {
  constexpr double B = 40;
  for (const std::vector<double>& angles :
       {std::vector<double>{0, 90, 180, 270}, {0, 90, 180, 270, 360}, {0, 45, 120, 200, 310}}) {
    const Layout layout = PhaseMeasuring{.frequency = 1, .angles = angles}.layout();
    const Band& band = layout.bands.front();
    std::mt19937_64 random(7);
    std::normal_distribution<double> w(0, std::sqrt(sigma_w2));
    Moments errors;
    for (int trial = 0; trial < trials; ++trial) {
      const double phi = 2 * pi * trial / trials;
      double C = 0, S = 0;
      for (std::size_t n = 0; n < angles.size(); ++n) {
        const double I = 100 + B * std::cos(phi - angles[n] * pi / 180) + w(random);
        C += band.cosine[n] * I;
        S += band.sine[n] * I;
      }
      errors.add(std::remainder(std::atan2(S, C) - phi, 2 * pi));
    }
    EXPECT_NEAR(errors.variance() / phase_variance(band, B, sigma_w2), 1, 0.03);
    EXPECT_NEAR(errors.mean(), 0, 1e-3);
    EXPECT_NEAR(coordinate_variance(layout, B, sigma_w2),
                coordinate_variance(phase_variance(band, B, sigma_w2), 1), 1e-12);
  }
}

TEST(PredictedVariance, OfMeanReflectivityAndAmbientLight) {
  for (const int N : {3, 4, 7}) {
    for (const double alpha : {0.3, 0.8}) {
      Moments mean, reflected, lit;
      for_each_noisy_pixel(
          N, alpha, [&](int n) { return 0.5 + 0.5 * std::cos(1.1 - 2 * pi * n / N); },
          [&](std::span<const double> I) {
            const PhaseSample sample = PhaseEquations(N)(I);
            const double a = reflectivity(sample.modulation, light.alpha_p);
            mean.add(sample.mean);
            reflected.add(a);
            lit.add(ambient_light(sample.mean, a, light));
          });
      EXPECT_NEAR(mean.variance() / (sigma_w2 / N), 1, 0.03);  // (3.14)
      EXPECT_NEAR(reflected.variance() / reflectivity_variance(N, light.alpha_p, sigma_w2), 1,
                  0.03);
      EXPECT_NEAR(lit.variance() / ambient_variance(N, alpha), 1, 0.03)
          << N << " steps, alpha " << alpha;
      EXPECT_NEAR(reflected.mean(), alpha, 1e-3);
      EXPECT_NEAR(lit.mean(), ambient, 0.05);
    }
  }
}

TEST(PredictedVariance, OfTheReferenceInTheDcChannel) {
  const double c1 = 0.5, c2 = 0.5, alpha = 0.5;
  for (const double R : {-0.8, 0.0, 0.8}) {
    Moments measured;
    for_each_noisy_pixel(
        3, alpha,
        [&](int n) { return 0.5 + 0.5 * c1 * std::cos(2 - 2 * pi * n / 3) + 0.5 * c2 * R; },
        [&](std::span<const double> I) {
          const PhaseSample sample = PhaseEquations(3)(I);
          const double a = reflectivity(sample.modulation, light.alpha_p, c1);
          measured.add((2 * (sample.mean - ambient) / (a * light.alpha_p) -
                        2 * (light.beta_p + ambient) / light.alpha_p - 1) /
                       c2);  // (3.65)
        });
    const double predicted = sigma_w2 * dc_reference_variance(alpha, light, ambient, c1, R);
    EXPECT_NEAR(measured.variance() / predicted, 1, 0.03) << "R " << R;
  }
}

TEST(PredictedVariance, OfTheReferenceInTheHalfPhaseChannel) {
  const double c1 = 0.6, c2 = 0.4, alpha = 0.5;
  for (const double R : {-0.8, 0.0, 0.8}) {
    Moments measured;
    for_each_noisy_pixel(
        4, alpha,
        [&](int n) {
          return 0.5 + 0.5 * c1 * std::cos(2 - pi * n / 2) + (n % 2 == 0 ? 0.5 : -0.5) * c2 * R;
        },
        [&](std::span<const double> I) {
          const double b_cos = (I[0] - I[1] + I[2] - I[3]) / 4;
          const double a = reflectivity(PhaseEquations(4)(I).modulation, light.alpha_p, c1);
          measured.add(2 * b_cos / (a * light.alpha_p * c2));  // (3.74)
        });
    const double predicted = sigma_w2 * half_phase_reference_variance(alpha, 200, c1, R);
    EXPECT_NEAR(measured.variance() / predicted, 1, 0.03) << "R " << R;
  }
}

TEST(PredictedVariance, OfReflectivityAndCueInTheSecondFullPhaseChannel) {
  const double alpha = 0.7;
  for (const double c1 : {0.3, 0.5, 0.8}) {
    const double c2 = 1 - c1;
    Moments first, second, weighted, cue;
    for_each_noisy_pixel(
        5, alpha,
        [&](int n) {
          return 0.5 + 0.5 * c1 * std::cos(1 - 2 * pi * n / 5) +
                 0.5 * c2 * std::cos(3 - 4 * pi * n / 5);
        },
        [&](std::span<const double> I) {
          // Taken in the order 0, 3, 1, 4, 2 the frames show the second channel as the first.
          const std::vector<double> J{I[0], I[3], I[1], I[4], I[2]};
          const PhaseSample other = PhaseEquations(5)(J);
          const double a1 = reflectivity(PhaseEquations(5)(I).modulation, light.alpha_p, c1);
          const double a2 = reflectivity(other.modulation, light.alpha_p, c2);
          first.add(a1);
          second.add(a2);
          weighted.add(weighted_reflectivity(a1, a2, c1));
          cue.add(std::remainder(other.wrapped_phase - 3, 2 * pi));
        });
    EXPECT_NEAR(first.variance() / reflectivity_variance(5, 200, sigma_w2, c1), 1, 0.03);
    EXPECT_NEAR(second.variance() / reflectivity_variance(5, 200, sigma_w2, c2), 1, 0.03);
    EXPECT_NEAR(weighted.variance() / weighted_reflectivity_variance(5, 200, sigma_w2), 1, 0.03);
    EXPECT_NEAR(cue.variance() / phase_variance(5, c2 * alpha, 200, sigma_w2), 1, 0.03);
  }
}

TEST(PredictedVariance, OfTheMultiplexedCoordinateIsEquation363) {
  const double expected = 2 * 1.55 / (3 * pi * pi * 0.25 * 200 * 200 * 0.25 * 9);
  EXPECT_NEAR(multiplexed_coordinate_variance(3, 0.5, 0.5, 3, 1.55), expected, 1e-15);
}

/// Whatever the strategy: of its layout alone.
TEST(PredictedVariance, OfALayoutsCoordinateIsTheEquationsOfItsStrategy) {
  for (const int N : {3, 4, 5, 6, 9}) {
    for (const double alpha : {0.15, 0.6, 1.0}) {
      const double B = alpha * light.alpha_p / 2;  // (3.4)
      for (const double f : {0.5, 1.0, 8.0}) {
        const double printed =
            2 * sigma_w2 /
            (pi * pi * N * alpha * alpha * light.alpha_p * light.alpha_p * f * f);  // (3.40)
        const double of_phase = phase_variance(N, alpha, light.alpha_p, sigma_w2);  // (3.38)
        const Layout pmp = PhaseMeasuring{.steps = N, .frequency = f}.layout();
        EXPECT_NEAR(phase_variance(pmp.bands[0], B, sigma_w2) / of_phase, 1, 1e-12);
        EXPECT_NEAR(coordinate_variance(pmp, B, sigma_w2) / printed, 1, 1e-12);
        EXPECT_NEAR(coordinate_variance(of_phase, f) / printed, 1, 1e-12);
        for (const int low_steps : {3, 8}) {
          const Layout dual =
              DualFrequency{.steps = N, .low_steps = low_steps, .high = 8 * f, .low = f / 8}
                  .layout();
          EXPECT_NEAR(coordinate_variance(dual, B, sigma_w2) / (printed / 64), 1, 1e-12);
        }
      }
      for (const double share : {0.3, 0.5, 0.8}) {
        const Layout pcmp = PhaseChannelMultiplexing{
            .steps = N,
            .high = 12,
            .share = share,
            .reference = {}}.layout();
        const double printed = multiplexed_coordinate_variance(N, alpha, share, 12, sigma_w2);
        EXPECT_NEAR(coordinate_variance(pcmp, share * B, sigma_w2) / printed, 1, 1e-12);
        if (N < 5) {
          EXPECT_NEAR(cue_variance(*pcmp.cue, sigma_w2) / (sigma_w2 / N), 1, 1e-12);
          continue;
        }
        const double c2 = 1 - share;
        EXPECT_NEAR(phase_variance(pcmp.bands[1], c2 * B, sigma_w2) /
                        phase_variance(N, c2 * alpha, light.alpha_p, sigma_w2),  // (3.101)
                    1, 1e-12);
      }
    }
  }
}

TEST(PredictedVariance, OfABandIsThatOfItsWeights) {
  EXPECT_NEAR(component_noise(phase_shifted_band(9, 2, 5, 3)) * sigma_w2, 2.0 / 5 * sigma_w2,
              1e-12);
  const Band own{.periods = 1, .cosine = {1, 0, -1}, .sine = {0, 1, -1}, .mean = {0, 0, 1}};
  EXPECT_DOUBLE_EQ(component_noise(own) * sigma_w2, 2 * sigma_w2);
  EXPECT_DOUBLE_EQ(phase_variance(own, 40, sigma_w2), 2 * sigma_w2 / 1600);
}

TEST(PredictedVariance, ReflectivityHasTheReliableRangeThatIsPrinted) {
  EXPECT_NEAR(least_reliable_reflectivity(55, -7), 0.1458, 1e-4);
  EXPECT_NEAR(least_beta_p(least_reliable_reflectivity(55, -7), -7), 55, 1e-9);
  EXPECT_EQ(least_reliable_reflectivity(0, 3), 0);
  EXPECT_EQ(least_beta_p(0.5, 3), 0);
  EXPECT_TRUE(std::isinf(least_reliable_reflectivity(5, -7)));
  const double step = 1e-6;
  EXPECT_NEAR(-7 / (0.4 * 0.4),  // (3.8), with the sign of the derivative
              (least_beta_p(0.4 + step, -7) - least_beta_p(0.4 - step, -7)) / (2 * step), 1e-4);
}

}  // namespace slipstream::predicted_variance_test
