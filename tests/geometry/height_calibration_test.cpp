#include "geometry/height_calibration.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "slipstream/error.h"
#include "tests/geometry/random_scanner.h"

namespace slipstream::height_calibration_test {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr Size camera{8, 6};

/// What the camera sees of a plane, tilted, that stands `height` nearer than where camera and
/// projector look, and the phase there.
Image<double> phase_at(const Scanner& scanner, double distance, double height) {
  const Eigen::Vector3d normal = Eigen::Vector3d(0.2, -0.15, -1).normalized();
  const Eigen::Vector3d at = Eigen::Vector3d(0, 0, distance) + height * normal;
  Image<double> phase(camera);
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      const Eigen::Vector3d ray = ray_through(scanner.camera, {column, row});
      const Eigen::Vector3d point = normal.dot(at) / normal.dot(ray) * ray;
      const Eigen::Vector2d pixel = project(scanner.projector, in_projector_frame(scanner, point));
      phase(column, row) = coordinate_along(Axis::x, pixel, scanner.projector.size);
    }
  }
  return phase;
}

std::vector<PlanePhase> planes_of(const Scanner& scanner, const std::vector<double>& heights) {
  std::vector<PlanePhase> planes;
  for (const double height : heights) planes.push_back({height, phase_at(scanner, 400, height)});
  return planes;
}

std::size_t measured(const Image<float>& heights) {
  return static_cast<std::size_t>(std::count_if(heights.begin(), heights.end(),
                                                [](float height) { return !std::isnan(height); }));
}

RC_GTEST_PROP(HeightCalibration, GivesHeightsBetweenItsPlanes, ()) {
  const Scanner scanner = random_scanner(*rc::gen::arbitrary<unsigned>(), 0, camera);
  std::vector<double> known{0};
  for (int i = *rc::gen::inRange(2, 6); i > 0; --i) known.push_back(i % 2 == 0 ? -5 * i : 8 * i);
  const HeightFit fit = fit_heights(planes_of(scanner, known));
  const double height = *rc::gen::inRange(-100, 80) / 10.;
  const Image<double> at_0 = phase_at(scanner, 400, 0), at_1 = phase_at(scanner, 400, 1);
  const Image<float> found = heights(fit.curves, phase_at(scanner, 400, height));
  for (std::size_t i = 0; i < found.pixel_count(); ++i) {
    const double slope = std::abs(at_1.begin()[i] - at_0.begin()[i]);
    if (slope < 2e-5) continue;  // along the stripes no depth is seen
    RC_ASSERT(std::abs(found.begin()[i] - height) < 1e-4 + 2e-7 / slope);
  }
  require_valid(fit.curves);
}

TEST(HeightCalibration, LeavesOutWhatIsNotKnown) {
  const Scanner scanner = random_scanner(3, 0, camera);
  std::vector<PlanePhase> planes = planes_of(scanner, {0, 10, 20, 30, 40});
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 1e-6);
  for (auto& [height, phase] : planes) {
    for (double& at : phase) at += noise(random);
  }
  for (std::size_t i = 0; i < 3; ++i) planes[i].phase(2, 1) = nan;  // two planes are left
  planes[4].phase(5, 1) = nan;                                      // four are
  planes[2].phase(3, 3) += 0.01;
  std::swap(planes[0].phase(1, 4), planes[2].phase(1, 4));  // rises and falls
  const HeightFit fit = fit_heights(planes);
  EXPECT_EQ(fit.pixels, 48U - 3);
  for (const auto& [column, row] : {std::pair(2, 1), {3, 3}, {1, 4}}) {
    EXPECT_TRUE(std::isnan(fit.curves(column, row).reference));
  }
  for (const double rms : fit.rms) EXPECT_LT(rms, 0.05);
  const auto pixels_at = [&](double height) {
    return measured(heights(fit.curves, phase_at(scanner, 400, height)));
  };
  EXPECT_EQ(pixels_at(39), 44U);  // not the one that did not see the highest
  EXPECT_EQ(pixels_at(-3), 45U);
  EXPECT_EQ(pixels_at(55), 0U);
  EXPECT_EQ(pixels_at(-10), 0U);
  EXPECT_EQ(measured(heights(fit.curves, Image<double>(camera, nan))), 0U);
}

TEST(HeightCalibration, RefusesWhatIsNone) {
  const Scanner scanner = random_scanner(3, 0, camera);
  const auto refused = [&](const std::vector<double>& heights) {
    EXPECT_THROW((void)fit_heights(planes_of(scanner, heights)), Error);
  };
  refused({});
  refused({0, 10});
  refused({0, 10, 10});
  refused({10, 20, 30});
  std::vector<PlanePhase> planes = planes_of(scanner, {0, 10, 20});
  const Image<HeightCurve> curves = fit_heights(planes).curves;
  EXPECT_THROW((void)heights(curves, Image<double>({8, 5})), Error);
  EXPECT_THROW(require_valid(Image<HeightCurve>(camera)), Error);
  for (float HeightCurve::*member : {&HeightCurve::slope, &HeightCurve::bend, &HeightCurve::lowest,
                                     &HeightCurve::highest, &HeightCurve::reference}) {
    for (const double wrong : {nan, 1e38, -1e38, std::numeric_limits<double>::infinity()}) {
      Image<HeightCurve> other = curves;
      other(3, 3).*member = static_cast<float>(wrong);
      const bool is_left_out = member == &HeightCurve::reference && std::isnan(wrong);
      const bool is_far = member == &HeightCurve::reference && std::abs(wrong) == 1e38;
      if (is_left_out || is_far) continue;
      if (member == &HeightCurve::slope && std::isfinite(wrong)) continue;  // heights of nearly 0
      EXPECT_THROW(require_valid(other), Error) << wrong;
    }
  }
  planes[1].phase = Image<double>({8, 5});
  EXPECT_THROW((void)fit_heights(planes), Error);
  planes[1].phase = Image<double>(camera, 0.5);
  planes[0].phase = planes[2].phase = planes[1].phase;
  EXPECT_THROW((void)fit_heights(planes), Error);
}

}  // namespace slipstream::height_calibration_test
