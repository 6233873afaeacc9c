#include "geometry/lens_residual.h"

#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/named_scenes.h"
#include "tests/io/expect_error.h"

namespace slipstream::lens_residual_test {

/// A lens with a residual of a few tenths of a pixel.
Lens bent_lens(int degree) {
  Lens lens = example_scanner({640, 480}).camera;
  std::mt19937 random(static_cast<unsigned>(degree));
  std::normal_distribution<double> number(0, 0.05);

  lens.residual = {.centre = {319.5, 239.5}, .half = {320, 240}};
  for (int i = 0; i < residual_term_count(degree); ++i) {
    const double x = number(random), y = number(random);
    lens.residual.terms.emplace_back(x, y);
  }
  return lens;
}

/// Equations for both components at places all over the picture, or its left part.
std::vector<ResidualSample> samples_of(const LensResidual& residual, double width = 640) {
  std::vector<ResidualSample> samples;
  for (double x = 5; x < width; x += 12) {
    for (double y = 5; y < 480; y += 12) {
      const Eigen::Vector2d shift = shift_at(residual, {x, y});
      samples.push_back({{x, y}, Eigen::Vector2d::UnitX(), shift.x()});
      samples.push_back({{x, y}, Eigen::Vector2d::UnitY(), shift.y()});
    }
  }
  return samples;
}

TEST(LensResidual, ShiftsPixelsAndComesBack) {
  for (const int degree : {1, 2, 4, 6, 14}) {
    const Lens lens = bent_lens(degree);
    Lens straight = lens;
    straight.residual = {};
    EXPECT_FALSE(is_straight(lens));

    for (const Eigen::Vector2d& pixel :
         {Eigen::Vector2d(0, 0), Eigen::Vector2d(320, 240), Eigen::Vector2d(639, 100)}) {
      const Eigen::Vector3d ray = ray_through(lens, pixel);
      EXPECT_LT((project(lens, 700 * ray) - pixel).norm(), 1e-9) << degree;

      const Eigen::Vector2d ideal = pixel - shift_at(lens.residual, pixel);
      EXPECT_LT((ray_through(straight, ideal) - ray).norm(), 1e-12) << degree;
    }
  }
}

TEST(LensResidual, StaysWithThePictureThatItShifts) {
  const Lens lens = bent_lens(4);
  const Lens part = part_of(lens, {.x = 100, .y = 50, .size = {300, 200}});
  EXPECT_LT((ray_through(part, {20, 30}) - ray_through(lens, {120, 80})).norm(), 1e-12);

  const LensResidual half = scaled(lens.residual, 0.5);
  EXPECT_LT((2 * shift_at(half, {60, 40}) - shift_at(lens.residual, {120, 80})).norm(), 1e-12);
}

TEST(LensResidual, OfAHighDegreeStopsAtTheRimOfThePicture) {
  const LensResidual residual = bent_lens(6).residual;
  const double rim = 319.5 + 1.1 * 320;
  EXPECT_LT((shift_at(residual, {5 * rim, 100}) - shift_at(residual, {rim, 100})).norm(), 1e-12);
}

TEST(LensResidual, IsFittedWithoutWrongSamples) {
  for (const int degree : {2, 4, 8}) {
    const LensResidual truth = bent_lens(degree).residual;
    std::vector<ResidualSample> samples = samples_of(truth);
    for (std::size_t i = 0; i < samples.size(); i += 10) samples[i].off += 5;

    const LensResidual found = fitted_residual(samples, {640, 480}, degree);
    for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(20, 30), Eigen::Vector2d(400, 300)}) {
      EXPECT_LT((shift_at(found, pixel) - shift_at(truth, pixel)).norm(), 0.01) << degree;
    }
  }
}

TEST(LensResidual, IsSmallWhereThePictureHasNoSamples) {
  const LensResidual truth = bent_lens(8).residual;
  const LensResidual found = fitted_residual(samples_of(truth, 320), {640, 480}, 8);
  double largest = 0;
  for (double y = 0; y < 480; y += 20) {
    largest = std::max(largest, shift_at(found, {620, y}).norm());
  }
  EXPECT_LT(largest, 2);
}

TEST(LensResidual, IsRefusedUnlessItIsComplete) {
  Scanner scanner = example_scanner();
  scanner.projector.residual.terms.resize(4, Eigen::Vector2d::Zero());
  expect_error([&] { require_valid(scanner); }, {"projector: invalid residual map"});
  scanner.projector.residual.terms.resize(1);
  expect_error([&] { require_valid(scanner); }, {"projector: invalid residual map"});

  scanner = example_scanner();
  scanner.camera.residual = bent_lens(2).residual;
  scanner.camera.residual.terms[1].x() = std::numeric_limits<double>::quiet_NaN();
  expect_error([&] { require_valid(scanner); }, {"camera: invalid residual map"});
}

}  // namespace slipstream::lens_residual_test
