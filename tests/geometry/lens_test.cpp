#include <cmath>
#include <limits>
#include <vector>

#include <gtest/gtest.h>
#include <opencv2/calib3d.hpp>

#include "slipstream/error.h"
#include "slipstream/scanner.h"

namespace slipstream::lens_test {

const std::vector<double> all_coefficients{-0.21, 0.11, 1e-3,  -2e-3, 0.03, 0.02, -0.04,
                                           0.01,  2e-3, -1e-3, 1e-3,  3e-3, 0.02, -0.03};

Lens lens_with(std::size_t coefficients) {
  Lens lens;
  lens.intrinsic << 1100, 0.7, 655, 0, 1090, 480, 0, 0, 1;
  lens.distortion = make_distortion(std::span(all_coefficients).first(coefficients));
  lens.size = {1280, 960};
  return lens;
}

class LensOf : public testing::TestWithParam<std::size_t> {};

TEST_P(LensOf, ProjectsAsOpenCvDoes) {
  Lens lens = lens_with(GetParam());
  lens.intrinsic(0, 1) = 0;  // OpenCV knows no skew
  const cv::Matx33d K(1100, 0, 655, 0, 1090, 480, 0, 0, 1);
  const std::vector<double> coefficients(all_coefficients.begin(),
                                         all_coefficients.begin() + static_cast<long>(GetParam()));
  for (const Eigen::Vector3d& point : {Eigen::Vector3d(0, 0, 500), Eigen::Vector3d(180, -90, 600),
                                       Eigen::Vector3d(-300, 250, 900)}) {
    std::vector<cv::Point2d> expected;
    cv::projectPoints(std::vector<cv::Point3d>{{point.x(), point.y(), point.z()}}, cv::Vec3d(),
                      cv::Vec3d(), K, coefficients, expected);
    const Eigen::Vector2d pixel = project(lens, point);
    EXPECT_NEAR(pixel.x(), expected[0].x, 1e-9);
    EXPECT_NEAR(pixel.y(), expected[0].y, 1e-9);
  }
}

TEST_P(LensOf, RayThroughAPixelComesBackToIt) {
  const Lens lens = lens_with(GetParam());
  for (int row = 0; row < 960; row += 37) {
    for (int column = 0; column < 1280; column += 41) {
      const Eigen::Vector2d pixel(column, row);
      const Eigen::Vector2d back = project(lens, 700 * ray_through(lens, pixel));
      ASSERT_LT((back - pixel).norm(), 1e-10);
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Coefficients, LensOf, testing::Values(0U, 4U, 5U, 8U, 12U, 14U));

TEST(Lens, UndistortedPixelsHaveNoDistortionLeft) {
  const Lens lens = lens_with(5);
  const Image<PixelPosition> positions = undistorted_pixels(lens);
  const Eigen::Vector3d ray = ray_through(lens, {37, 801});
  const Eigen::Vector3d ideal = lens.intrinsic * ray;
  EXPECT_NEAR(positions(37, 801).x, ideal.x(), 1e-10);
  EXPECT_NEAR(positions(37, 801).y, ideal.y(), 1e-10);
}

TEST(Lens, IsNanWhereTheModelFoldsOver) {
  const Distortion barrel = make_distortion(std::vector<double>{-0.5, 0, 0, 0});
  EXPECT_TRUE(undistort(barrel, {3, 0}).hasNaN());
  EXPECT_FALSE(undistort(barrel, {0.4, 0}).hasNaN());
}

// Pictures of a region of the sensor show what the whole picture shows there.
TEST(Lens, OfAPartSeesTheSameRays) {
  const Lens whole = lens_with(8);
  const Lens part = part_of(whole, {100, 50, {640, 480}});
  EXPECT_EQ(part.size, (Size{640, 480}));
  for (const Eigen::Vector2d& pixel : {Eigen::Vector2d(0, 0), Eigen::Vector2d(639, 479)}) {
    const Eigen::Vector2d in_whole = pixel + Eigen::Vector2d(100, 50);
    EXPECT_TRUE(ray_through(part, pixel).isApprox(ray_through(whole, in_whole), 1e-12));
  }

  EXPECT_THROW(part_of(whole, {700, 0, {640, 480}}), Error);
  EXPECT_THROW(part_of(whole, {-1, 0, {640, 480}}), Error);
  EXPECT_THROW(part_of(whole, {0, 0, {0, 480}}), Error);
}

TEST(Lens, RefusesWhatIsNoLens) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(make_distortion(std::vector<double>{1, 2, 3}), Error);
  EXPECT_THROW(make_distortion(std::vector<double>{0, 0, 0, nan}), Error);
  Lens lens = lens_with(5);
  EXPECT_NO_THROW(require_valid(lens, "camera"));
  lens.intrinsic(0, 0) = 0;
  EXPECT_THROW(require_valid(lens, "camera"), Error);
  lens = lens_with(5);
  lens.intrinsic(2, 2) = 2;
  EXPECT_THROW(require_valid(lens, "camera"), Error);
}

}  // namespace slipstream::lens_test
