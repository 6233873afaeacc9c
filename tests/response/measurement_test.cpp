#include "slipstream/response/measurement.h"

#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "slipstream/base/error.h"
#include "tools/reproduce/board_experiment.h"

namespace slipstream::measurement_test {

/// Traced once for all tests.
const BoardExperiment& white_board() {
  static const BoardExperiment board({160, 120});
  return board;
}
const BoardExperiment& textured_board() {
  static const BoardExperiment board({160, 120}, BoardExperiment::Surface::textured);
  return board;
}

GammaEstimate measured(const BoardExperiment& board, double gamma) {
  constexpr int steps = 20;
  const FrameSet frames = board.averaged(steps, gamma, 5, 4);
  const Image<MeasuredHarmonics> pixels = pixel_harmonics(frames, 0, steps);
  return robust_gamma(gamma_map(pixels, well_lit(pixels, frames)));
}

TEST(MeasuredGamma, OfATexturedObjectIsThatOfTheWhiteBoard) {
  for (const double gamma : {2.21, 4.42, 7.73}) {
    const GammaEstimate white = measured(white_board(), gamma);
    const GammaEstimate veined = measured(textured_board(), gamma);
    EXPECT_NEAR(veined.gamma, gamma, 0.005);
    EXPECT_NEAR(veined.gamma, white.gamma, 0.005);
    EXPECT_LT(veined.standard_error, 0.002);
  }
}

TEST(RobustGamma, HasTheStandardErrorItSays) {
  // Gaussian pixels by a sum of 12 uniform ones; 200 maps, one gamma each.
  std::uint32_t state = 7;
  const auto uniform = [&] {
    state = state * 1664525U + 1013904223U;
    return state / 4294967296.0;
  };
  constexpr int maps = 200;
  double squares = 0, promised = 0;
  for (int i = 0; i < maps; ++i) {
    Image<double> map({20, 20});
    for (double& pixel : map) {
      pixel = -6;
      for (int k = 0; k < 12; ++k) pixel += uniform();
      pixel = 2.2 + 0.1 * pixel;
    }
    map(0, 0) = 1000;
    map(1, 0) = std::numeric_limits<double>::quiet_NaN();
    const GammaEstimate estimate = robust_gamma(map);
    squares += (estimate.gamma - 2.2) * (estimate.gamma - 2.2);
    promised += estimate.standard_error;
  }
  EXPECT_NEAR(std::sqrt(squares / maps) / (promised / maps), 1, 0.25);
}

TEST(RobustGamma, RefusesAMapWithHardlyAnyPixel) {
  Image<double> map({20, 20}, std::numeric_limits<double>::quiet_NaN());
  for (int i = 0; i < 20; ++i) map(i, 0) = 2;
  EXPECT_THROW((void)robust_gamma(map), Error);
}

TEST(Histogram, CountsWhatIsInside) {
  Image<double> map({4, 1});
  map(0, 0) = 1.1;
  map(1, 0) = 1.9;
  map(2, 0) = 2;
  map(3, 0) = std::numeric_limits<double>::quiet_NaN();
  const Histogram counted = histogram(map, 1, 2, 2);
  EXPECT_EQ(counted.counts, (std::vector<std::size_t>{1, 1}));
}

TEST(FitGamma, FindsTheCurveItIsGiven) {
  rc::check([] {
    const double gamma = *rc::gen::inRange(50, 1100) / 100.0;
    const double offset = *rc::gen::inRange(-50, 200) / 10.0;
    std::vector<double> values, intensities;
    for (int i = 0; i <= 17; ++i) {
      values.push_back(i / 17.0);
      intensities.push_back(offset + 180 * std::pow(values.back(), gamma));
    }
    const GammaFit fit = fit_gamma(values, intensities);
    RC_ASSERT(std::abs(fit.gamma - gamma) < 1e-4 * gamma);
    RC_ASSERT(std::abs(fit.offset - offset) < 1e-2);
    RC_ASSERT(fit.rms < 1e-2);
  });
}

TEST(FitGamma, RefusesWhatSaysNothing) {
  const std::vector<double> same(6, 0.5), rising{0, 0.2, 0.4, 0.6, 0.8, 1};
  const std::vector<double> falling{6, 5, 4, 3, 2, 1};
  EXPECT_THROW((void)fit_gamma(same, rising), Error);
  EXPECT_THROW((void)fit_gamma(rising, falling), Error);
  EXPECT_THROW((void)fit_gamma(std::vector{0.0, 0.5, 1.0}, std::vector{1.0, 2.0, 3.0}), Error);
}

}  // namespace slipstream::measurement_test
