#include "slipstream/scanner.h"

#include <optional>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "slipstream/pattern_set.h"

namespace slipstream::scanner_test {

TEST(Scanner, ItsLargestTangentIsThatOfTheFarthestCornerWithTheMargin) {
  // The axis is in one corner; the diagonal lies between the directions that are searched.
  Lens lens{.size = {1000, 937}};
  lens.intrinsic << 1000, 0, 0, 0, 1000, 0, 0, 0, 1;
  const double corner = Eigen::Vector2d(1.5, 1.5 * 0.937).norm();
  const std::optional<double> largest = largest_tangent(lens, {0.5, 0.5});
  ASSERT_TRUE(largest);
  EXPECT_GE(*largest, corner);
  EXPECT_LT(*largest, 1.03 * corner);
}

TEST(Scanner, SeesDepthUnlessItsBaselineIsAlongTheStripes) {
  Scanner scanner;
  for (const Eigen::Vector3d& baseline :
       {Eigen::Vector3d(-100, 0, 0), Eigen::Vector3d(0, 0, -100), Eigen::Vector3d(0, 99, 1)}) {
    scanner.translation = baseline;
    EXPECT_NO_THROW(require_depth_visible(scanner, Axis::x)) << baseline.transpose();
  }
  scanner.translation = {0, -100, 0};
  EXPECT_THROW(require_depth_visible(scanner, Axis::x), Error);
  EXPECT_NO_THROW(require_depth_visible(scanner, Axis::y));
}

}  // namespace slipstream::scanner_test
