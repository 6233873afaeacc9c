// One-bit patterns under the projector's blur: what docs/how-to/binary-patterns.md says of their
// phase. Patterns that vary along both axes, in the light of the virtual projector.
#include "simulate/projected_light.h"

#include <array>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "response/correction.h"
#include "simulate/seen_scene.h"
#include "slipstream/pattern_set.h"
#include "slipstream/phase_shifting.h"

namespace slipstream::projected_light_test {

using std::numbers::pi;

constexpr Size projector{960, 256};

PatternSet fringes(int steps, double period, bool binary = true) {
  return {.count = steps,
          .light = {},
          .shape =
              [=](int n, double y) {
                return sinusoid_intensity({steps, projector.width / period}, n, y);
              },
          .binary = binary};
}

ProjectedLight light(const PatternSet& patterns, int n, const Photometry& photometry = {}) {
  return projected_light(patterns, n, projector, photometry, SeenScene{{1, 1}});
}

/// Anywhere but near the edges, where it is dark beyond.
std::vector<LitSample> samples(double blur) {
  constexpr int count = 20000;
  constexpr double margin = 32;
  std::mt19937 random(2011);
  std::uniform_real_distribution<double> column(margin, projector.width - margin),
      row(margin, projector.height - margin);
  std::vector<LitSample> places;
  for (int i = 0; i < count; ++i) {
    places.push_back({.pixel = {column(random), row(random)}, .strength = 1, .blur = blur});
  }
  return places;
}

/// RMS, rad, against the phase of true grey.
double phase_error(int steps, double period, double blur) {
  const std::vector<LitSample> places = samples(blur);
  std::vector<std::complex<double>> sums(places.size());
  for (int n = 0; n < steps; ++n) {
    const ProjectedLight at = light(fringes(steps, period), n);
    for (std::size_t i = 0; i < places.size(); ++i) {
      sums[i] += at(places[i]) * std::polar(1.0, 2 * pi * n / steps);
    }
  }
  double squares = 0;
  for (std::size_t i = 0; i < places.size(); ++i) {
    // The light is even over a pixel: without a blur its phase is that of the pixel's centre.
    const double place = blur == 0 ? std::round(places[i].pixel.x()) : places[i].pixel.x();
    squares += std::pow(std::remainder(std::arg(sums[i]) - 2 * pi * place / period, 2 * pi), 2);
  }
  return std::sqrt(squares / static_cast<double>(places.size()));
}

TEST(ProjectedLight, BinaryPatternsErrOfPhaseFallsWithDefocus) {
  constexpr std::array blurs{0.0, 0.5, 1.0, 2.0, 3.0};
  constexpr std::array most{0.9, 0.35, 0.065, 0.013, 0.006};
  std::printf("| N | period | 0 px | 0.5 px | 1 px | 2 px | 3 px |\n");
  for (const int steps : {3, 4, 6}) {
    for (const double period : {16.0, 32.0, 64.0}) {
      std::printf("| %d | %.0f px |", steps, period);
      double before = pi;
      for (std::size_t i = 0; i < blurs.size(); ++i) {
        const double error = phase_error(steps, period, blurs[i]);
        std::printf(" %.4f |", error);
        EXPECT_LT(error, most[i]) << blurs[i];
        EXPECT_LT(error, before) << blurs[i];
        before = error;
      }
      std::printf("\n");
    }
  }
}

TEST(ProjectedLight, BinaryPatternsLightIsThatOfGreyWherePixelsAreBlurredAway) {
  for (const int n : {0, 1, 2}) {
    const ProjectedLight bits = light(fringes(3, 64), n), grey = light(fringes(3, 64, false), n);
    for (const LitSample& sample : samples(4)) {
      const double blurred = 0.5 + (grey(sample) / 255 - 0.5) * std::exp(-2 * std::pow(pi / 16, 2));
      EXPECT_NEAR(bits(sample) / 255, blurred, 0.01);
    }
  }
}

TEST(ProjectedLight, BinaryPatternsAnswerNoGamma) {
  const ProjectedLight linear = light(fringes(3, 32), 1);
  const ProjectedLight bent = light(fringes(3, 32), 1, {.response = PowerLaw{2.2}});
  for (const LitSample& sample : samples(1)) EXPECT_NEAR(linear(sample), bent(sample), 1e-9);
}

TEST(ProjectedLight, BinaryPatternsHalfOfTheLightSpreadsWithinASurface) {
  const ProjectedLight bits = light(fringes(3, 32), 0);
  LitSample sample{.pixel = {100.3, 80.7}, .strength = 1, .blur = 3};
  const double sharp = bits(sample);
  sample.blur = 5;
  const double spread = bits(sample);
  sample.blur = 3;
  sample.spread = 4;
  EXPECT_NEAR(bits(sample), (sharp + spread) / 2, 1e-9);
}

constexpr Size wide_projector{512, 384};
constexpr double along_period = 32, across_period = 12;  // projector pixels

double phase_at(const Eigen::Vector2d& pixel, Axis axis) {
  const double along = axis == Axis::x ? pixel.x() : pixel.y();
  const double other = axis == Axis::x ? pixel.y() : pixel.x();
  return 2 * pi * (along / along_period + other / across_period);
}

PatternSet oblique(Axis axis) {
  const double f = length_along(axis, wide_projector) / along_period;
  const double c = length_along(across(axis), wide_projector) / across_period;
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
  SeenScene seen{{1, 1}};
  seen.widest.front() = widest_blur({&sample, 1});
  std::complex<double> sum = 0;
  for (int n = 0; n < 3; ++n) {
    const double light =
        projected_light(oblique(axis), n, wide_projector, photometry, seen)(sample);
    sum += 2.0 / 3 * light * std::polar(1.0, 2 * pi * n / 3);
  }
  return sum;
}

TEST(ProjectedLight, CarrierPatternsLightAPixelByBothOfItsCoordinates) {
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
TEST(ProjectedLight, CarrierPatternsLoseTheModulationThatDefocusTakes) {
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

}  // namespace slipstream::projected_light_test
