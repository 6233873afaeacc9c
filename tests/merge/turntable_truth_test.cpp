// A statue that turns before a virtual scanner in the bench world, against the true surface.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "base/numbers.h"
#include "merge/fused_model.h"
#include "merge/point_grid.h"
#include "merge/turntable_views.h"
#include "simulate/turned_scene.h"
#include "slipstream/engine.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"

namespace slipstream::turntable_truth_test {

constexpr int view_count = 12;
constexpr double step = 30 * degree;

const Sequence sequence{
    .strategy = make_strategy("dual-frequency", {{"steps", 8}, {"high", 64}, {"low", 1}})};

VirtualWorld statue_world(Size camera) {
  return virtual_world({.scene = "statue", .camera = camera, .world = "bench"});
}

/// The statue as view `k` shows it; a hand moved it before view `moved`, unless that is 0.
Scene scene_of_view(const VirtualWorld& world, int k, int moved) {
  Scene scene = world.scene;
  const Eigen::Vector3d on_axis = turntable_axis(world.scanner).point;
  const Eigen::Isometry3d by_hand =
      Eigen::Translation3d(1.5, 0.3, -1) * Eigen::Translation3d(on_axis) *
      Eigen::AngleAxisd(2 * degree, Eigen::Vector3d(0.2, -1, 0.1).normalized()) *
      Eigen::Translation3d(-on_axis);
  for (Body& body : scene) {
    if (moved > 0 && k >= moved) body.pose = by_hand * body.pose;
  }
  return turned_scene(scene, world.scanner, k * step);
}

std::vector<PreparedView> views_of(const VirtualWorld& world, int moved) {
  Engine engine(as_calibrated(world), sequence);
  std::vector<View> views;
  for (int k = 0; k < view_count; ++k) {
    Photometry photometry = world.photometry;
    photometry.seed += static_cast<std::uint64_t>(k);
    const FrameSet frames =
        take_scan(world.scanner, scene_of_view(world, k, moved), pattern_set(sequence), photometry)
            .frames;

    Cloud cloud;
    Maps maps;
    engine.cloud_and_maps(frames, cloud, maps);
    const Uncertainty uncertainty = engine.uncertainty(cloud, maps, frames);
    views.push_back(view_of(cloud, &uncertainty, "view " + std::to_string(k + 1)));
  }

  const float cell = keypoint_cell(views);
  std::vector<PreparedView> prepared;
  for (View& view : views) prepared.emplace_back(std::move(view), cell);
  return prepared;
}

TurntableFit fit_of(const std::vector<PreparedView>& views) {
  const JointAlignment joint = join_views(views);
  EXPECT_EQ(joint.joined(), static_cast<std::size_t>(view_count));
  const std::vector<PairPose> pairs = pair_poses(joint.links);
  TurntableFit fit = fit_turntable(view_count, pairs);
  refine_on_surfaces(views, pairs, fit);
  return fit;
}

/// RMS distance of the model's points from the surface along their normals, mm.
double distance_from(const FusedModel& model, const Scene& scene) {
  constexpr double farthest = 2;  // mm; beyond are points across an edge

  const std::vector<PlacedBody> bodies = placed_at(scene, 0);
  double squares = 0, count = 0;
  for (const ModelPoint& point : model.points) {
    const Eigen::Vector3d normal = point.normal.cast<double>();
    const Eigen::Vector3d above = point.position.cast<double>() + farthest * normal;
    const auto surface = first_surface(bodies, {above, -normal});
    const double error = surface ? (above - surface->point).norm() - farthest : farthest;
    if (error >= farthest) continue;
    squares += error * error;
    ++count;
  }
  EXPECT_GT(count, 0.99 * static_cast<double>(model.points.size()));
  return std::sqrt(squares / count);
}

/// Places on the true surface that a camera sees in one of the views, in the first view's frame.
std::vector<Eigen::Vector3f> seen_places(const VirtualWorld& world) {
  constexpr int every = 8;  // pixels

  std::vector<Eigen::Vector3f> places;
  const TurnAxis axis = turntable_axis(world.scanner);
  for (int k = 0; k < view_count; ++k) {
    const Eigen::Isometry3d back = Eigen::Translation3d(axis.point) *
                                   Eigen::AngleAxisd(-k * step, axis.direction) *
                                   Eigen::Translation3d(-axis.point);
    const Scene scene = scene_of_view(world, k, 0);
    const std::vector<PlacedBody> bodies = placed_at(scene, 0);
    for (int row = 0; row < world.scanner.camera.size.height; row += every) {
      for (int column = 0; column < world.scanner.camera.size.width; column += every) {
        const Eigen::Vector3d ray = ray_through(world.scanner.camera, Eigen::Vector2d(column, row));
        const auto seen = first_surface(bodies, {Eigen::Vector3d::Zero(), ray});
        if (seen) places.push_back((back * seen->point).cast<float>());
      }
    }
  }
  return places;
}

/// Number of places without a point near them.
std::size_t holes_in(const std::vector<std::uint32_t>& views_at, std::uint32_t views) {
  return static_cast<std::size_t>(std::ranges::count_if(
      views_at, [&](std::uint32_t at_place) { return (at_place & views) == 0; }));
}

TEST(TurntableTruth, TwelveViewsOfAStatueAreTheTrueStatue) {
  const VirtualWorld world = statue_world({640, 480});
  const std::vector<PreparedView> views = views_of(world, 0);
  const TurntableFit fit = fit_of(views);

  // 1. The axis.
  const Eigen::Vector3d right = turntable_axis(world.scanner).direction;
  const Eigen::Vector3d is = fit.table.direction;
  EXPECT_LT(std::atan2(right.cross(is).norm(), std::abs(right.dot(is))), 0.02 * degree);
  EXPECT_FALSE(fit.moved);

  // Errors that all views share are not in the standard deviation, which is 0.0016 mm here.
  const Eigen::Vector3d off = fit.table.point - turntable_axis(world.scanner).point;
  EXPECT_LT((off - right.dot(off) * right).norm(), 0.03) << "mm";

  // 2. The surface.
  std::vector<const View*> sources;
  std::vector<std::optional<Eigen::Isometry3d>> poses;
  for (int k = 0; k < view_count; ++k) {
    sources.push_back(&views[static_cast<std::size_t>(k)].view());
    poses.emplace_back(fit.poses[static_cast<std::size_t>(k)]);
  }
  const FusedModel model = fuse(sources, poses);
  EXPECT_LT(distance_from(model, scene_of_view(world, 0, 0)), 0.05) << "mm";

  // 3. Holes: which views, and the model as a further one, have a point at each place.
  const std::vector<Eigen::Vector3f> places = seen_places(world);
  std::vector<std::uint32_t> views_at(places.size());
  const auto mark = [&](const std::vector<Eigen::Vector3f>& points, int bit) {
    const PointGrid grid(points, 2 * model.spacing);
    for (std::size_t i = 0; i < places.size(); ++i) {
      if (grid.nearest(places[i], 1.5F * model.spacing)) views_at[i] |= 1U << bit;
    }
  };
  std::vector<Eigen::Vector3f> points;
  for (const ModelPoint& point : model.points) points.push_back(point.position);
  mark(points, view_count);
  for (int k = 0; k < view_count; ++k) {
    points.clear();
    for (const Eigen::Vector3f& point : sources[static_cast<std::size_t>(k)]->points) {
      points.push_back(fit.poses[static_cast<std::size_t>(k)].cast<float>() * point);
    }
    mark(points, k);
  }

  std::size_t fewest = places.size();
  for (std::uint32_t six = 0; six < 1U << view_count; ++six) {
    if (std::popcount(six) == 6) fewest = std::min(fewest, holes_in(views_at, six));
  }
  EXPECT_LT(holes_in(views_at, 1U << view_count), fewest);
}

TEST(TurntableTruth, AViewThatWasMovedByHandIsNamed) {
  const TurntableFit fit = fit_of(views_of(statue_world({320, 240}), 7));
  ASSERT_TRUE(fit.moved);
  EXPECT_EQ(fit.moved->view, 7U);
}

}  // namespace slipstream::turntable_truth_test
