#include "geometry/point_fit.h"

#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "base/numbers.h"
#include "geometry/rotation.h"
#include "slipstream/error.h"

namespace slipstream::point_fit_test {

using Points = std::vector<Eigen::Vector3d>;

const Points triangle{{0, 0, 500}, {120, 0, 510}, {0, 80, 530}};

Points moved_by(const Eigen::Isometry3d& pose, Points points) {
  for (Eigen::Vector3d& point : points) point = pose * point;
  return points;
}

RC_GTEST_PROP(PointFit, FindsAnyPoseFromThreePoints, ()) {
  const auto any = [] { return *rc::gen::inRange(-1000, 1001) * 1e-3; };
  const Eigen::Vector3d turn(any(), any(), any()), shift(any(), any(), any());
  const Eigen::Isometry3d pose = pose_from(rotation_of_vector(3 * turn), 1000 * shift);

  const PointFit fit = fit_points(triangle, moved_by(pose, triangle));
  RC_ASSERT((fit.pose.matrix() - pose.matrix()).cwiseAbs().maxCoeff() < 1e-9);
  RC_ASSERT(fit.rms < 1e-9);
}

TEST(PointFit, SaysWhichPointIsOff) {
  Points points = triangle;
  points.insert(points.end(), {{120, 80, 540}, {60, 40, 480}, {-50, 90, 500}});
  Points partners = points;
  partners[4].z() += 3;

  const PointFit fit = fit_points(points, partners);
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i == 4) continue;
    EXPECT_LT(fit.residuals[i], fit.residuals[4]);
  }
  EXPECT_GT(fit.rms, 0.5);
}

TEST(PointFit, StepsTurnAboutTheirCentreAndLeaveOutWhatIsOpen) {
  const Eigen::Vector3d centre(10, 20, 500), shift(1, 2, 3);
  Vector6 step;
  step << 0, 0, 90 * degree, shift;
  const Eigen::Isometry3d motion = motion_about(centre, step);
  EXPECT_LT((motion * centre - centre - shift).norm(), 1e-9);
  EXPECT_LT(
      (motion * (centre + Eigen::Vector3d::UnitX()) - centre - shift - Eigen::Vector3d::UnitY())
          .norm(),
      1e-9);

  Matrix6 squares = Matrix6::Identity();
  squares(5, 5) = 0;
  Vector6 known = Vector6::Ones();
  known[5] = 0;
  EXPECT_LT((known_step(squares, Vector6::Ones()) - known).norm(), 1e-12);
}

TEST(PointFit, RefusesPointsThatDoNotDetermineIt) {
  const Points line{{0, 0, 1}, {0, 0, 2}, {0, 0, 3}};
  EXPECT_THROW(fit_points(line, triangle), Error);
  EXPECT_THROW(fit_points(triangle, line), Error);
  EXPECT_THROW(fit_points(Points(2, {1, 2, 3}), Points(2, {1, 2, 3})), Error);
  EXPECT_THROW(fit_points(triangle, Points(4, {1, 2, 3})), Error);

  Points damaged = triangle;
  damaged[1].x() = nan;
  EXPECT_THROW(fit_points(damaged, triangle), Error);
}

}  // namespace slipstream::point_fit_test
