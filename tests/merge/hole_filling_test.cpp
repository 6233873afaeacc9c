// Meshes of a sphere whose holes are known.
#include "merge/hole_filling.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace slipstream::hole_filling_test {

constexpr float radius = 20, spacing = 0.8F;

/// A sphere, without the points around the given directions: {direction, radius of the hole, mm}.
ModelMesh sphere_with_holes(const std::vector<std::pair<Eigen::Vector3f, float>>& holes) {
  FusedModel model{.spacing = spacing};
  const int count = static_cast<int>(16 * std::numbers::pi * radius * radius / spacing);
  for (int i = 0; i < count; ++i) {
    const float z = 1 - (2 * static_cast<float>(i) + 1) / static_cast<float>(count);
    const float turn = static_cast<float>(i) * 2.3999632F;
    const float across = std::sqrt(1 - z * z);
    const Eigen::Vector3f normal(across * std::cos(turn), across * std::sin(turn), z);
    const bool is_missing = std::ranges::any_of(holes, [&](const auto& hole) {
      return radius * (normal - hole.first.normalized()).norm() < hole.second;
    });
    if (is_missing) continue;
    model.points.push_back({.position = radius * normal, .normal = normal, .views = 1});
  }
  return mesh_of(model);
}

/// Edges with one triangle; none may have more than one on a side.
int open_edges(const ModelMesh& mesh) {
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> count;
  for (const auto& triangle : mesh.triangles) {
    for (std::size_t k = 0; k < 3; ++k) ++count[{triangle[k], triangle[(k + 1) % 3]}];
  }

  int open = 0;
  for (const auto& [edge, times] : count) {
    EXPECT_EQ(times, 1);
    if (!count.contains({edge.second, edge.first})) ++open;
  }
  return open;
}

TEST(HoleFilling, ClosesTheHolesUpToTheWidth) {
  ModelMesh mesh = sphere_with_holes({{{0, 0, 1}, 3.0F}, {{1, 0, 0}, 2.0F}, {{0, 1, 0.2F}, 8.0F}});
  ASSERT_GT(open_edges(mesh), 0);
  const std::size_t before = mesh.triangles.size();

  EXPECT_EQ(fill_holes(mesh, 10), 2);
  const int left = open_edges(mesh);
  EXPECT_GT(left, 2 * std::numbers::pi * 6 / spacing / 2);

  EXPECT_EQ(fill_holes(mesh, 30), 1);
  EXPECT_EQ(open_edges(mesh), 0);

  // They face outwards, and lie as deep below the sphere as planes through the rims.
  for (std::size_t i = before; i < mesh.triangles.size(); ++i) {
    const auto& [a, b, c] = mesh.triangles[i];
    const Eigen::Vector3f &p = mesh.vertices[a].position, &q = mesh.vertices[b].position,
                          &r = mesh.vertices[c].position;
    const Eigen::Vector3f middle = (p + q + r) / 3;
    EXPECT_GE((q - p).cross(r - p).dot(middle), -1e-3F);
    EXPECT_GT(middle.norm(), std::sqrt(radius * radius - 64) - 2 * spacing);
  }
}

/// The volume within, mm^3: a triangle that lay over another would change it.
double volume_of(const ModelMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    sum +=
        mesh.vertices[a].position.cross(mesh.vertices[b].position).dot(mesh.vertices[c].position);
  }
  return sum / 6;
}

TEST(HoleFilling, FillsRimsOfAnyForm) {
  // Two overlapping gaps make a rim with notches; a third nearly touches them.
  ModelMesh mesh = sphere_with_holes(
      {{{0, 0, 1}, 3.0F}, {{0.22F, 0, 1}, 3.0F}, {{0.1F, 0.2F, 1}, 1.5F}, {{0, -0.33F, 1}, 2.0F}});
  EXPECT_GE(fill_holes(mesh, 20), 1);
  EXPECT_EQ(open_edges(mesh), 0);
  EXPECT_NEAR(volume_of(mesh), 4.0 / 3 * std::numbers::pi * radius * radius * radius, 250);
}

// The base of a part is as wide as the part: its surface runs straight or outwards to the rim.
TEST(HoleFilling, ClosesTheBaseOfAPart) {
  for (const float flare : {0.0F, 0.4F}) {
    FusedModel model{.spacing = spacing};
    for (float z = 0; z <= 20; z += spacing / 2) {
      const float wide = 8 + flare * z;
      const int around = static_cast<int>(4 * std::numbers::pi * wide / spacing);
      for (int i = 0; i < around; ++i) {
        const float turn = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / around;
        const Eigen::Vector3f out(std::cos(turn), std::sin(turn), 0);
        model.points.push_back({.position = wide * out + z * Eigen::Vector3f::UnitZ(),
                                .normal = (out - flare * Eigen::Vector3f::UnitZ()).normalized(),
                                .views = 1});
      }
    }

    ModelMesh mesh = mesh_of(model);
    EXPECT_EQ(fill_holes(mesh, 60), 2) << flare;
    EXPECT_EQ(open_edges(mesh), 0) << flare;
    EXPECT_GT(volume_of(mesh), 0.8 * std::numbers::pi * 64 * 20) << flare;
  }
}

TEST(HoleFilling, LeavesAWholeMeshAndAnEmptyOneAsTheyAre) {
  ModelMesh whole = sphere_with_holes({});
  const auto triangles = whole.triangles;
  EXPECT_EQ(fill_holes(whole, 1000), 0);
  EXPECT_EQ(whole.triangles, triangles);

  ModelMesh none;
  EXPECT_EQ(fill_holes(none, 1000), 0);
}

}  // namespace slipstream::hole_filling_test
