// Models of views whose noise and surface are known.
#include "merge/fused_model.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "merge/model_surface.h"
#include "tests/merge/virtual_shots.h"

namespace slipstream::fused_model_test {

using Poses = std::vector<std::optional<Eigen::Isometry3d>>;

/// Errors of a model along its normals.
struct Errors {
  double rms = 0;
  double z_rms = 0;  ///< in the points' standard deviations
};

Errors errors_of(const FusedModel& model, const MeshTree& object, const Eigen::Isometry3d& pose,
                 int least_views) {
  constexpr double least_facing = 0.6;

  const Scene scene{Body{.shape = std::make_shared<const MeshTree>(object), .pose = pose}};
  const std::vector<PlacedBody> bodies = placed_at(scene, 0);
  double squares = 0, z_squares = 0, count = 0;
  for (const ModelPoint& point : model.points) {
    const Eigen::Vector3d place = point.position.cast<double>();
    const double facing = std::abs(point.normal.cast<double>().dot(place.normalized()));
    if (point.views < least_views || facing < least_facing) continue;
    const auto hit = first_surface(bodies, {Eigen::Vector3d::Zero(), place});
    if (!hit) continue;

    const double error = (hit->distance - 1) * place.norm() * facing;
    squares += error * error;
    z_squares += error * error / (point.sigma * point.sigma);
    ++count;
  }
  return {std::sqrt(squares / count), std::sqrt(z_squares / count)};
}

TEST(FusedModelFuse, LowersTheNoiseAsTheVariancesSay) {
  const MeshTree object(relief());
  const Eigen::Isometry3d pose = before_camera(turned({1, 0, 0}, 5));
  const View first = view_at(object, pose, 0.1, 1), second = view_at(object, pose, 0.1, 2);
  const Poses poses{Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity()};

  const Errors one = errors_of(fuse({&first, &second}, {poses[0], std::nullopt}), object, pose, 1);
  const Errors two = errors_of(fuse({&first, &second}, poses), object, pose, 2);
  EXPECT_NEAR(two.rms / one.rms, std::sqrt(0.5), 0.05 * std::sqrt(0.5));
  EXPECT_GT(one.z_rms, 0.9);
  EXPECT_LT(one.z_rms, 1.1);
  EXPECT_GT(two.z_rms, 0.9);
  EXPECT_LT(two.z_rms, 1.1);
}

TEST(FusedModelFuse, WeighsTheViewsByTheirNoise) {
  const MeshTree object(relief());
  const Eigen::Isometry3d pose = before_camera(turned({1, 0, 0}, 5));
  const View good = view_at(object, pose, 0.05, 1), bad = view_at(object, pose, 0.5, 2);
  const Poses poses{Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity()};

  const Errors alone = errors_of(fuse({&good, &bad}, {poses[0], std::nullopt}), object, pose, 1);
  EXPECT_LT(errors_of(fuse({&good, &bad}, poses), object, pose, 1).rms, 1.05 * alone.rms);
}

TEST(FusedModelFuse, CarriesColoursAndCountsViews) {
  const MeshTree object(relief());
  const Shot shot = shot_of(object, before_camera(turned({1, 0, 0}, 5)), 0.05, 1);
  Image<Colour> colours(shot.cloud.size(), Colour{200, 100, 50});
  const View view = view_of(shot.cloud, &shot.uncertainty, "view", &colours);
  const Poses poses{Eigen::Isometry3d::Identity(), Eigen::Isometry3d::Identity()};

  const FusedModel model = fuse({&view, &view}, poses);
  ASSERT_FALSE(model.points.empty());
  EXPECT_TRUE(model.coloured);
  for (const ModelPoint& point : model.points) {
    EXPECT_EQ(point.colour, (Colour{200, 100, 50}));
    EXPECT_EQ(point.views, 2);
    EXPECT_EQ(point.disagreement, 0);
  }
}

TEST(FusedModelFuse, SaysHowFarViewsDisagree) {
  const MeshTree object(relief());
  const Eigen::Isometry3d pose = before_camera(turned({1, 0, 0}, 5));
  const View first = view_at(object, pose, 0.01, 1), second = view_at(object, pose, 0.01, 2);
  const Poses poses{Eigen::Isometry3d::Identity(),
                    Eigen::Isometry3d(Eigen::Translation3d(0, 0, 0.5))};

  double sum = 0;
  const FusedModel model = fuse({&first, &second}, poses);
  for (const ModelPoint& point : model.points) sum += point.disagreement;
  EXPECT_NEAR(sum / static_cast<double>(model.points.size()), 0.5, 0.1);
}

TEST(FusedModelMeshOf, LiesOnTheSurfaceAndFacesOutwards) {
  const MeshTree object(relief());
  const Eigen::Isometry3d pose = before_camera(turned({1, 0, 0}, 5));
  const View view = view_at(object, pose, 0.02, 1);
  const FusedModel model = fuse({&view}, {Eigen::Isometry3d::Identity()});
  const ModelMesh mesh = mesh_of(model);

  ASSERT_GT(mesh.triangles.size(), model.points.size());
  std::vector<bool> is_corner(mesh.vertices.size());
  for (const auto& triangle : mesh.triangles) {
    for (const std::uint32_t corner : triangle) is_corner.at(corner) = true;
  }
  EXPECT_EQ(std::ranges::count(is_corner, false), 0);

  std::size_t turned_away = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    const Eigen::Vector3f& first = mesh.vertices[a].position;
    const Eigen::Vector3f normal =
        (mesh.vertices[b].position - first).cross(mesh.vertices[c].position - first);
    if (normal.dot(mesh.vertices[a].normal) < 0) ++turned_away;
  }
  EXPECT_LT(turned_away, mesh.triangles.size() / 1000);
  FusedModel corners = model;
  corners.points = mesh.vertices;
  EXPECT_LT(errors_of(corners, object, pose, 1).rms, 0.1);
}

TEST(FusedModelMeshOf, LeavesHolesOpen) {
  const MeshTree object(plate([](double, double) { return 0.0; }));
  const View view = view_at(object, before_camera(turned({1, 0, 0}, 5)), 0.02, 1);
  FusedModel model = fuse({&view}, {Eigen::Isometry3d::Identity()});
  std::erase_if(model.points,
                [](const ModelPoint& point) { return point.position.head<2>().norm() < 20; });

  for (const ModelPoint& vertex : mesh_of(model).vertices) {
    EXPECT_GT(vertex.position.head<2>().norm(), 20 - 3 * model.spacing);
  }
}

}  // namespace slipstream::fused_model_test
