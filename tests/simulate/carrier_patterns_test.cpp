// Patterns that vary along both axes, in the light of the virtual projector.
#include <cmath>
#include <complex>
#include <numbers>

#include <gtest/gtest.h>

#include "slipstream/simulate/projected_light.h"

namespace slipstream::carrier_patterns_test {

using std::numbers::pi;

constexpr Size projector{512, 384};
constexpr double along_period = 32, across_period = 12;  // projector pixels

double phase_at(const Eigen::Vector2d& pixel, Axis axis) {
  const double along = axis == Axis::x ? pixel.x() : pixel.y();
  const double other = axis == Axis::x ? pixel.y() : pixel.x();
  return 2 * pi * (along / along_period + other / across_period);
}

PatternSet oblique(Axis axis) {
  const double f = length_along(axis, projector) / along_period;
  const double c = length_along(across(axis), projector) / across_period;
  return {.count = 3,
          .axis = axis,
          .light = {.alpha_p = 200, .beta_p = 20},
          .shape =
              [=](int n, double y, double x) {
                return 0.5 + 0.5 * std::cos(2 * pi * (f * y + c * x) - 2 * pi * n / 3);
              },
          .carrier = true};
}

/// A + B exp(i phi) at a sample, from three steps.
std::complex<double> phasor(const LitSample& sample, Axis axis, const Photometry& photometry) {
  SeenScene seen({1, 1});
  seen.samples.resize(1);
  seen.samples.front().push_back(sample);
  std::complex<double> sum = 0;
  for (int n = 0; n < 3; ++n) {
    const double light = projected_light(oblique(axis), n, projector, photometry, seen)(sample);
    sum += 2.0 / 3 * light * std::polar(1.0, 2 * pi * n / 3);
  }
  return sum;
}

TEST(CarrierPatterns, LightAPixelByBothOfItsCoordinates) {
  for (const Axis axis : {Axis::x, Axis::y}) {
    for (const Eigen::Vector2d pixel : {Eigen::Vector2d(100.3, 70.8), {259.9, 333.25}}) {
      const auto z = phasor({.pixel = pixel, .strength = 1}, axis, {});
      EXPECT_NEAR(std::abs(z), 100, 1e-9);
      EXPECT_NEAR(std::remainder(std::arg(z) - phase_at(pixel, axis), 2 * pi), 0, 1e-9);
    }
  }
}

/// A Gaussian, and the evenness of a pixel, take from the modulation what they take of both
/// periods.
TEST(CarrierPatterns, LoseTheModulationThatDefocusTakes) {
  const auto kept = [](double period, double blur) {
    const double pixel = std::sin(pi / period) / (pi / period);
    return pixel * std::exp(-2 * std::pow(pi * blur / period, 2));
  };
  Photometry photometry;
  for (const bool pixels : {false, true}) {
    photometry.physics.projector_pixels = pixels;
    for (const Axis axis : {Axis::x, Axis::y}) {
      for (const double blur : {1.0, 2.0, 4.0}) {
        const Eigen::Vector2d pixel(200.3, 170.8);
        const auto z = phasor({.pixel = pixel, .strength = 1, .blur = blur}, axis, photometry);
        EXPECT_NEAR(std::abs(z), 100 * kept(along_period, blur) * kept(across_period, blur), 0.3);
        EXPECT_NEAR(std::remainder(std::arg(z) - phase_at(pixel, axis), 2 * pi), 0, 0.01);
      }
    }
  }
}

}  // namespace slipstream::carrier_patterns_test
