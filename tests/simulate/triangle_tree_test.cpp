// The tree of triangles against a search of all of them. Tier: every change.
#include "simulate/triangle_tree.h"

#include <array>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "simulate/ray_packet.h"
#include "simulate/sculptures.h"
#include "slipstream/scene.h"

namespace slipstream::triangle_tree_test {

/// Distance of the nearest triangle, found one by one; infinite without one.
double nearest_of_all(const Mesh& mesh, const Ray& ray) {
  double nearest = std::numeric_limits<double>::infinity();
  for (const auto& [i, j, k] : mesh.triangles) {
    // origin + t direction = corner + a side_a + b side_b.
    Eigen::Matrix3d sides;
    sides << ray.direction, mesh.vertices[i] - mesh.vertices[j],
        mesh.vertices[i] - mesh.vertices[k];
    if (sides.determinant() == 0) continue;
    const Eigen::Vector3d tab = sides.inverse() * (mesh.vertices[i] - ray.origin);
    if (tab[0] > 0 && tab[1] >= 0 && tab[2] >= 0 && tab[1] + tab[2] <= 1) {
      nearest = std::min(nearest, tab[0]);
    }
  }
  return nearest;
}

/// Packets from one origin: narrow, to all sides, and along the axes.
std::vector<LaneVectors> packets() {
  std::mt19937 random(67);
  std::normal_distribution<double> normal;
  std::vector<LaneVectors> packets(9);
  for (std::size_t n = 0; n < packets.size(); ++n) {
    const Eigen::Vector3d towards(0.1 * normal(random), 0.1 * normal(random), -1);
    const double spread = n % 3 == 0 ? 0.003 : 1;
    for (int i = 0; i < packet_rays; ++i) {
      const Eigen::Vector3d off(normal(random), normal(random), normal(random));
      packets[n].set(i, n % 3 == 2 ? Eigen::Vector3d(Eigen::Vector3d::Unit(i % 3) * (i - 7.5))
                                   : Eigen::Vector3d(towards + spread * off));
    }
  }
  return packets;
}

Mesh two_ellipsoids() {
  Mesh mesh;
  append_ellipsoid(mesh, {0, 0.1, 0}, {0.4, 0.5, 0.3});
  append_ellipsoid(mesh, {0.1, 0.1, 0.4}, {0.2, 0.1, 0.15});
  return mesh;
}

TEST(TriangleTree, FindsTheNearestOfAllTriangles) {
  const Mesh mesh = two_ellipsoids();
  const TriangleTree tree(mesh);
  int hits = 0;
  for (const Eigen::Vector3d& origin : {Eigen::Vector3d(0.05, 0.1, 2), {0.01, 0.2, 0.01}}) {
    for (const LaneVectors& directions : packets()) {
      Lanes distance;
      distance.fill(std::numeric_limits<double>::infinity());
      std::array<int, packet_rays> triangle{};
      tree.find_first(origin, directions, distance, triangle);

      // Half of the rays end before that triangle, the others behind it.
      Lanes limit;
      for (int i = 0; i < packet_rays; ++i) limit[i] = distance[i] * (i % 2 == 0 ? 0.999 : 1.001);
      Lanes blocked = limit;
      tree.find_any(origin, directions, blocked);

      for (int i = 0; i < packet_rays; ++i) {
        const double nearest = nearest_of_all(mesh, {origin, directions.at(i)});
        ASSERT_EQ(triangle[i] >= 0, std::isfinite(nearest)) << i;
        if (triangle[i] < 0) continue;
        ++hits;
        EXPECT_NEAR(distance[i], nearest, 1e-12 * nearest) << i;
        EXPECT_EQ(blocked[i], i % 2 == 0 ? limit[i] : -1) << i;
      }
    }
  }
  EXPECT_GT(hits, 100);
}

TEST(TriangleTree, LeavesOutRaysOfNegativeDistance) {
  const TriangleTree tree(two_ellipsoids());
  LaneVectors directions;
  Lanes distance;
  for (int i = 0; i < packet_rays; ++i) {
    directions.set(i, {0, 0, -1});
    distance[i] = i == 3 ? 10 : -1;
  }
  std::array<int, packet_rays> triangle{};
  tree.find_first({0, 0.1, 2}, directions, distance, triangle);
  for (int i = 0; i < packet_rays; ++i) EXPECT_EQ(triangle[i] >= 0, i == 3) << i;
}

TEST(TriangleTree, MeetsPolesBetweenTrianglesWithoutArea) {
  // At each pole of an ellipsoid every second triangle has two corners in one place.
  constexpr double radius = 0.5;
  Mesh ball;
  append_ellipsoid(ball, {0, 0, 0}, {radius, radius, radius});
  const TriangleTree tree(ball);

  for (const double side : {-1.0, 1.0}) {
    // The first ray meets the pole itself, the others lie beside it.
    const Eigen::Vector3d origin(0, 2 * side, 0);
    LaneVectors directions;
    for (int i = 0; i < packet_rays; ++i) {
      directions.set(i, {0.002 * i, -1.5 * side, 0.003 * i});
    }

    Lanes distance;
    distance.fill(std::numeric_limits<double>::infinity());
    std::array<int, packet_rays> triangle{};
    tree.find_first(origin, directions, distance, triangle);

    for (int i = 0; i < packet_rays; ++i) {
      ASSERT_GE(triangle[i], 0) << i;
      const Eigen::Vector3d point = origin + distance[i] * directions.at(i);
      EXPECT_NEAR(point.norm(), radius, 2e-3) << i;
      EXPECT_GT(tree.normal(triangle[i]).norm(), 0) << i;
    }
  }
}

}  // namespace slipstream::triangle_tree_test
