// Views of clouds with stray points.
#include "merge/view.h"

#include <cstddef>

#include <gtest/gtest.h>

#include "tests/merge/virtual_shots.h"

namespace slipstream::view_test {

const Eigen::Isometry3d pose = before_camera(turned({1, 0, 0}, 5));

/// A shot of a relief, a share of whose points is at `place` instead.
Shot shot_with_strays(double share, const Eigen::Vector3f& place) {
  Shot shot = shot_of(MeshTree(relief()), pose, 0.05, 1);
  const auto wanted =
      static_cast<std::size_t>(share * static_cast<double>(point_count(shot.cloud)));

  std::size_t moved = 0;
  for_each_pixel_in_order(shot.cloud.size(), [&](int column, int row) {
    if (moved == wanted || shot.cloud.validity(column, row) != Validity::valid) return;
    const auto offset = static_cast<float>(moved % 97);
    shot.cloud.x(column, row) = place.isZero(0) ? 0 : place.x() + offset;
    shot.cloud.y(column, row) = place.y();
    shot.cloud.z(column, row) = place.z();
    ++moved;
  });
  return shot;
}

std::size_t turned_away(const View& view) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < view.size(); ++i) {
    if (view.normals[i].dot(view.points[i]) > 0) ++count;
  }
  return count;
}

TEST(ViewViewOf, LeavesOutPointsAtTheOrigin) {
  const Shot shot = shot_with_strays(0.05, Eigen::Vector3f::Zero());
  const View view = view_of(shot.cloud, &shot.uncertainty);
  EXPECT_TRUE(view.from_origin);
  EXPECT_EQ(turned_away(view), 0U);
}

TEST(ViewViewOf, LeavesOutAFewPointsThatTheCameraCannotSee) {
  const Shot shot = shot_with_strays(0.005, {0, 0, -500});
  const View view = view_of(shot.cloud, &shot.uncertainty);
  EXPECT_TRUE(view.from_origin);
  EXPECT_EQ(turned_away(view), 0U);
  for (const Eigen::Vector3f& point : view.points) EXPECT_GT(point.z(), 0);
}

TEST(ViewViewOf, IsNotFromTheOriginIfManyPointsAreBehindIt) {
  const Shot shot = shot_with_strays(0.2, {0, 0, -500});
  EXPECT_FALSE(view_of(shot.cloud, &shot.uncertainty).from_origin);
}

}  // namespace slipstream::view_test
