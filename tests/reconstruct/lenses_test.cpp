// The fused pass gives the points of the equations for lenses as bent as OpenCV calibrates them,
// and refuses those whose model is not invertible over their picture.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/engine.h"
#include "tests/geometry/random_scanner.h"
#include "tests/reconstruct/agreement.h"

namespace slipstream::lenses_test {

/// Distortion up to twice that of real lenses, at the picture's farthest corner: the polynomials of
/// r^2, one in three rational with a thin prism, and one in six with a tilted sensor.
Distortion random_distortion(const Lens& lens, std::mt19937& random) {
  const auto uniform = [&](double largest) {
    return std::uniform_real_distribution<double>(-2 * largest, 2 * largest)(random);
  };
  const Eigen::Matrix3d& K = lens.intrinsic;
  const auto farthest = [&](int i, int length) {
    return std::max(K(i, 2), length - K(i, 2)) / K(i, i);
  };
  const double square =
      std::pow(farthest(0, lens.size.width), 2) + std::pow(farthest(1, lens.size.height), 2);
  const bool rational = random() % 3 == 0, tilted = random() % 6 == 0;
  constexpr std::array<double, 3> radial{0.15, 0.08, 0.06};
  std::array<double, 14> k{};
  for (const std::size_t i : {0U, 1U, 2U}) {
    const double power = std::pow(square, i + 1.0);
    k[5 + i] = rational ? uniform(radial[i]) / power : 0;
    k[i < 2 ? i : 4] = k[5 + i] + uniform(radial[i]) / power;
  }
  for (const std::size_t i : {2U, 3U}) k[i] = uniform(0.002);
  for (std::size_t i = 8; i < 12; ++i) k[i] = rational ? uniform(0.003) : 0;
  for (const std::size_t i : {12U, 13U}) k[i] = tilted ? uniform(0.02) : 0;
  return make_distortion(k);
}

/// How far beyond the picture and the axis, in the picture's lengths, the lens first turns back
/// along a ray from the axis; negative inside. At most 0.05.
double turning_point(const Lens& lens) {
  constexpr int rays = 120;
  constexpr double step = 5e-3, farthest = 0.05;
  double nearest = farthest;
  const double axis_x = lens.intrinsic(0, 2) / lens.size.width;
  const double axis_y = lens.intrinsic(1, 2) / lens.size.height;
  for (int i = 0; i < rays; ++i) {
    const double angle = 2 * std::numbers::pi * i / rays;
    const Eigen::Vector2d along(std::cos(angle), std::sin(angle));
    double beyond = -1;
    for (double r = step; beyond < nearest; r += step) {
      const auto bent = [&](double x, double y) {
        return distort(lens.distortion, r * along + 1e-6 * Eigen::Vector2d(x, y));
      };
      Eigen::Matrix2d change;
      change << bent(1, 0) - bent(-1, 0), bent(0, 1) - bent(0, -1);
      if (!(change.determinant() > 0)) {
        nearest = beyond;
        break;
      }
      const Eigen::Vector3d pixel = lens.intrinsic * bent(0, 0).homogeneous();
      const double x = pixel.x() / lens.size.width, y = pixel.y() / lens.size.height;
      beyond = std::max({std::min(0.0, axis_x) - x, std::min(0.0, axis_y) - y,
                         x - std::max(1.0, axis_x), y - std::max(1.0, axis_y)});
    }
  }
  return nearest;
}

/// Frames of one period in which every pixel sees some place of the projector.
FrameSet random_places(Size size, std::mt19937& random) {
  constexpr double turn = 2 * std::numbers::pi;
  FrameSet::Images16 frames(3, Image<std::uint16_t>(size));
  for (std::size_t i = 0; i < frames[0].pixel_count(); ++i) {
    const double y = std::uniform_real_distribution<double>(-0.01, 1.01)(random);
    for (std::size_t n = 0; n < 3; ++n) {
      const double level = 30000 + 25000 * std::cos(turn * (y - static_cast<double>(n) / 3));
      frames[n].begin()[i] = static_cast<std::uint16_t>(std::lround(level));
    }
  }
  return FrameSet(std::move(frames), 16);
}

/// Returns how many points there are.
std::size_t expect_points_of_the_equations(const EngineSetup& setup, const FrameSet& frames) {
  const auto& [scanner, sequence, settings] = setup;
  const ReferenceResult exact = by_equations(setup, frames);
  Cloud cloud;
  FusedMemory memory;
  FusedEngine::make(setup, {}).value()(frames, {.cloud = &cloud}, memory);
  EXPECT_LE(compare(scanner, sequence.axis, cloud, exact).worst, depth_bound);
  std::size_t points = 0, missing = 0;
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    const bool found = cloud.validity(column, row) == Validity::valid;
    points += found ? 1 : 0;
    if (exact.cloud.validity(column, row) == Validity::valid) {
      missing += found ? 0 : 1;
    } else if (found) {
      // The secant method of the equations fails for a few points.
      const Eigen::Vector3d point = in_projector_frame(scanner, position_at(cloud, column, row));
      const Eigen::Vector2d pixel = project(scanner.projector, point);
      const Size size = scanner.projector.size;
      EXPECT_NEAR(coordinate_along(sequence.axis, pixel, size), exact.maps.coordinate(column, row),
                  1e-5);
      EXPECT_LE(std::abs(coordinate_along(across(sequence.axis), pixel, size) - 0.5), 0.521);
    }
  });
  EXPECT_LE(missing, 1U);
  return points;
}

TEST(Lenses, AreSolvedWhereTheyAreInvertible) {
  int fused = 0, refused = 0, unsolved = 0;
  std::vector<unsigned> seeds(500);
  std::iota(seeds.begin(), seeds.end(), 0U);
  seeds.push_back(12254);  // for one pixel Newton's method does not end
  for (const unsigned seed : seeds) {
    SCOPED_TRACE(seed);
    std::mt19937 random(seed);
    Scanner scanner = random_scanner(seed, 0, {48, 36});
    // Many projectors look up from the lower edge of their picture or below.
    if (seed % 4 == 0) {
      scanner.projector.intrinsic(1, 2) =
          (1 + 0.001 * (seed % 200)) * scanner.projector.size.height;
    }
    for (Lens* const lens : {&scanner.camera, &scanner.projector}) {
      lens->distortion = random_distortion(*lens, random);
    }
    const Eigen::Vector3d& T = scanner.translation;
    const Axis axis = std::abs(T.x()) > std::abs(T.y()) ? Axis::x : Axis::y;
    const EngineSetup setup = setup_of(scanner, PhaseMeasuring{.steps = 3, .frequency = 1}, axis);
    std::string why_not;
    const bool possible = FusedEngine::make(setup, {}, &why_not).has_value();
    const double turning =
        std::min(turning_point(scanner.camera), turning_point(scanner.projector));
    if (turning > 0.03 && !possible) ++unsolved;
    if (turning < -0.03) EXPECT_FALSE(possible);
    if (possible) {
      EXPECT_GT(expect_points_of_the_equations(setup, random_places({48, 36}, random)), 100U);
      ++fused;
    } else {
      EXPECT_TRUE(why_not.ends_with("lens model cannot be inverted over its picture")) << why_not;
      ++refused;
    }
  }
  EXPECT_GE(fused, 250);
  EXPECT_GE(refused, 50);
  EXPECT_EQ(unsolved, 0);
}

}  // namespace slipstream::lenses_test
