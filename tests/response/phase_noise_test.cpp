// Phase noise of 8-bit virtual scans against Liu 2010, Eq. (3.38), with the noise of rounding.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "codes/predicted_variance.h"
#include "decode/decoder.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream::phase_noise_test {

using std::numbers::pi;

constexpr double sigma_w2 = 1.55;
// Bright enough to stay off 0 and dark enough to stay off 255 at every alpha below, noise included.
constexpr PatternLight light{.alpha_p = 220, .beta_p = 10};

/// Variance of decoded minus true phase over a board of that reflectivity.
double measured_phase_variance(int steps, double alpha) {
  const Scanner scanner = example_scanner({400, 300});
  const Strategy strategy = PhaseMeasuring{.steps = steps, .frequency = 1};
  Scene scene = scene_named("board", scanner);
  scene.front().texture = uniform_texture(alpha);
  const VirtualScan scan =
      take_scan(scanner, scene, pattern_set(strategy, Axis::x, light),
                {.ambient = 5, .noise_variance = sigma_w2, .bits = 8, .seed = 11});
  const BasicMaps<double> decoded =
      Decoder(strategy.layout(), scanner.projector.size.width, PhaseMethod::tables)(scan.frames);

  double sum = 0, sum_of_squares = 0, count = 0;
  for (std::size_t i = 0; i < scan.coordinate.pixel_count(); ++i) {
    const double error = decoded.wrapped_phase.begin()[i] - 2 * pi * scan.coordinate.begin()[i];
    if (std::isnan(error)) continue;
    const double around = std::remainder(error, 2 * pi);
    sum += around;
    sum_of_squares += around * around;
    ++count;
  }
  EXPECT_GT(count, 50000);
  return sum_of_squares / count - sum * sum / (count * count);
}

class PhaseNoise : public testing::TestWithParam<int> {};

TEST_P(PhaseNoise, IsAsPredictedWithinFivePercent) {
  const int steps = GetParam();
  for (const double alpha : {0.2, 0.4, 0.6, 0.8, 1.0}) {
    const double predicted =
        phase_variance(steps, alpha, light.alpha_p, sigma_w2 + quantisation_variance);
    const double measured = measured_phase_variance(steps, alpha);
    EXPECT_NEAR(measured / predicted, 1, 0.05) << "alpha " << alpha;
  }
}

INSTANTIATE_TEST_SUITE_P(N, PhaseNoise, testing::Values(3, 4, 6, 8));

TEST(PhaseNoiseCoordinateVariance, IsEquation340) {
  // 2 sigma_w^2 / (pi^2 N alpha^2 alpha_p^2 f^2)
  const double expected = 2 * 1.55 / (pi * pi * 5 * 0.36 * 200 * 200 * 64);
  EXPECT_NEAR(coordinate_variance(phase_variance(5, 0.6, 200, 1.55), 8), expected, 1e-15);
}

}  // namespace slipstream::phase_noise_test
