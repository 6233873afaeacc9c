// Two and three virtual cameras around one projector, fused to one cloud.
#include "scan_job/fused_cameras.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"
#include "tests/io/expect_error.h"

namespace slipstream::fused_cameras_test {

const Sequence dual{.strategy = make_strategy("dual-frequency", {{"high", 16}, {"low", 1}})};

VirtualWorld statue_world() {
  VirtualWorld world{.scanner = example_scanner({160, 120}), .photometry = {.noise_variance = 1.6}};
  world.scanner.photometry.noise_variance = 1.6;
  world.scene = scene_named("statue", world.scanner);
  return world;
}

Scan taken(const VirtualWorld& world, const Sequence& sequence) {
  return merged(
      {.frames =
           take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry).frames,
       .sequence = sequence,
       .scanner = world.scanner});
}

Scan scan_of(int cameras, const Sequence& sequence) {
  const VirtualWorld world = statue_world();
  Scan scan = taken(world, sequence);
  for (int number = 2; number <= cameras; ++number) {
    scan.further_cameras.push_back(taken(seen_from_second(world, number), sequence));
  }
  return scan;
}

/// The points of each camera with the projector alone.
std::vector<ScanResult> results_of(int cameras) {
  std::vector<ScanResult> results;
  for (Scan& scan : scans_of_cameras(scan_of(cameras, dual))) {
    results.push_back(reconstruct(std::move(scan), {.uncertainty = true}));
  }
  return results;
}

/// Errors of points along their normals, of those within 2 mm of the surface that at least so many
/// cameras saw.
struct Errors {
  double rms = 0, z_rms = 0;  ///< mm; in the points' standard deviations
};

Errors errors_of(const FusedModel& model, const Scene& scene, int least_views) {
  constexpr double farthest = 2;  // mm; beyond are points across an edge

  const std::vector<PlacedBody> bodies = placed_at(scene, 0);
  double squares = 0, z_squares = 0, count = 0;
  for (const ModelPoint& point : model.points) {
    if (point.views < least_views) continue;
    const Eigen::Vector3d normal = point.normal.cast<double>();
    const Eigen::Vector3d above = point.position.cast<double>() + farthest * normal;
    const auto surface = first_surface(bodies, {above, -normal});
    if (!surface) continue;
    const double error = (above - surface->point).norm() - farthest;
    if (error > farthest) continue;

    squares += error * error;
    z_squares += std::pow(error / point.sigma, 2);
    ++count;
  }
  return {std::sqrt(squares / count), std::sqrt(z_squares / count)};
}

class FusedCamerasOfAStatue : public testing::TestWithParam<int> {};

TEST_P(FusedCamerasOfAStatue, HaveMorePointsThanEachAndLessErrorWhereTwoSee) {
  const std::vector<ScanResult> cameras = results_of(GetParam());
  const FusedModel fused = fused_cameras(cameras);
  const VirtualWorld world = statue_world();
  const Errors errors = errors_of(fused, world.scene, 2);
  EXPECT_GT(errors.z_rms, 0.9);
  EXPECT_LT(errors.z_rms, 1.1);

  // Each camera's points, averaged in the same way, in its own frame.
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    EXPECT_GT(fused.points.size(), cameras[i].counts[0]) << i;
    const FusedModel alone = fused_cameras(std::span(cameras).subspan(i, 1));
    const Scene seen =
        i == 0 ? world.scene : seen_from_second(world, static_cast<int>(i) + 1).scene;
    EXPECT_LT(errors.rms, errors_of(alone, seen, 1).rms) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Cameras, FusedCamerasOfAStatue, testing::Values(2, 3));

TEST(FusedCamerasPointsByEachOther, HaveTheOrdersThatOneCameraLacks) {
  const Sequence one_band{.strategy = make_strategy("pmp", {{"steps", 4}, {"frequency", 16}})};
  const std::vector<ScanResult> cameras =
      points_by_each_other({.scan = scan_of(2, one_band), .setup = {.sequence = one_band}},
                           reconstruct(scan_of(2, one_band)));
  ASSERT_EQ(cameras.size(), 2U);

  const FusedModel fused = fused_cameras(cameras);
  const Errors errors = errors_of(fused, statue_world().scene, 2);
  for (const ScanResult& camera : cameras) {
    const std::size_t points = count_by_validity(camera.cloud).front();
    EXPECT_GT(points, 3000U);
    EXPECT_GT(fused.points.size(), points);
  }
  EXPECT_GT(errors.z_rms, 0.9);
  EXPECT_LT(errors.z_rms, 1.1);
}

TEST(FusedCamerasSettingsFor, KeepABoxWhereItIs) {
  const PointBox box{{-20, -20, 300}, {20, 20, 1000}};
  std::vector<ScanResult> cameras;
  for (Scan& scan : scans_of_cameras(scan_of(2, dual))) {
    ScanJobSettings settings{.uncertainty = true};
    settings.reconstruct.clean.box = box;
    if (!cameras.empty()) {
      settings.reconstruct = settings_for(*scan.scanner, cameras.front().setup.scanner,
                                          std::move(settings.reconstruct));
    }
    cameras.push_back(reconstruct(std::move(scan), settings));
  }

  const FusedModel fused = fused_cameras(cameras);
  EXPECT_GT(fused.points.size(), 200U);
  for (const ModelPoint& point : fused.points) {
    EXPECT_LT(std::abs(point.position.x()), 20.1F);
    EXPECT_LT(std::abs(point.position.y()), 20.1F);
  }
}

TEST(FusedCameras, AreMadeByTheScanJobIfAskedFor) {
  const ScanResult alone = reconstruct(scan_of(2, dual));
  EXPECT_EQ(alone.fused, nullptr);
  expect_error([&] { (void)fused_points(alone); }, {"were not fused"});

  // The job's tables serve the next scan.
  ScanJob job({.fuse = true});
  const FusedModel model = fused_cameras(results_of(2));
  for (int i = 0; i < 2; ++i) {
    const ScanResult result = job(scan_of(2, dual));
    ASSERT_NE(result.fused, nullptr);
    ASSERT_EQ(result.fused->points.size(), model.points.size());
    EXPECT_EQ(result.fused->points.back().position, model.points.back().position);
    EXPECT_EQ(result.points_of_cameras.size(), 2U);

    const ModelPoints points = fused_points(result);
    const int last = points.cloud.size().width - 1;
    EXPECT_EQ(points.cloud.size(), (Size{static_cast<int>(model.points.size()), 1}));
    EXPECT_EQ(points.cloud.z(last, 0), model.points.back().position.z());
    EXPECT_EQ(points.normals.z(last, 0), model.points.back().normal.z());
  }

  EXPECT_EQ(reconstruct(scan_of(3, dual)).points_of_cameras.size(), 3U);
  expect_error([&] { (void)job(scan_of(1, dual)); }, {"`fuse`", "two or more cameras"});
}

TEST(FusedCameras, AreRefusedIfOneMovedSinceItsCalibration) {
  Scan scan = scan_of(2, dual);
  EXPECT_TRUE(reconstruct(scan, {.fuse = true}).checked.findings.empty());

  for (const double mm : {2.0, 20.0}) {
    Scan moved = scan;
    moved.further_cameras.front().scanner->translation.x() += mm;
    const ScanResult kept = reconstruct(moved, {.keep_refused = true, .fuse = true});
    ASSERT_EQ(kept.checked.findings.size(), 1U) << mm;
    EXPECT_EQ(kept.checked.findings.front().kind, FindingKind::cameras_apart) << mm;
    expect_error([&] { (void)reconstruct(moved, {.fuse = true}); }, {"a camera moved"});
  }
}

TEST(FusedCameras, MoveToAFrame) {
  const FusedModel model = fused_cameras(results_of(2));
  const FramePose pose{.from = "table",
                       .to = "camera",
                       .transform = Eigen::Translation3d(10, -20, 30) *
                                    Eigen::Isometry3d(Eigen::AngleAxisd(
                                        0.3, Eigen::Vector3d(1, 2, 3).normalized()))};
  FusedModel moved = model;
  move_to_frame(moved, pose);
  Cloud cloud = model_points(model).cloud;
  move_to_frame(cloud, pose);

  const Cloud same = model_points(moved).cloud;
  EXPECT_EQ(frame_name(same), "table");
  EXPECT_NEAR(same.x(0, 0), cloud.x(0, 0), 1e-3);
  EXPECT_NEAR(same.y(0, 0), cloud.y(0, 0), 1e-3);
  EXPECT_NEAR(same.z(0, 0), cloud.z(0, 0), 1e-3);

  // The pose leads from the table to the camera, so its inverse turns what the camera saw.
  const Eigen::Vector3d turned =
      pose.transform.linear().transpose() * model.points[0].normal.cast<double>();
  EXPECT_LT((moved.points[0].normal.cast<double>() - turned).norm(), 1e-5);
}

TEST(FusedCameras, AreNotMatchedWhereReflectionIsRejected) {
  ScanJobSettings settings;
  settings.reconstruct.clean.reflection = 3;
  expect_error([&] { (void)reconstruct(scan_of(2, dual), settings); }, {"`reflection`"});
  settings.fuse = true;
  EXPECT_GT(reconstruct(scan_of(2, dual), settings).fused->points.size(), 3000U);
}

TEST(FusedCameras, NeedOneProjectorAndPoints) {
  std::vector<ScanResult> cameras = results_of(2);
  cameras[1].setup.scanner.projector.intrinsic(0, 0) *= 1.1;
  expect_error([&] { (void)fused_cameras(cameras); }, {"different projectors"});

  cameras[0].cloud.validity = Image<Validity>(cameras[0].cloud.size(), Validity::too_dark);
  expect_error([&] { (void)fused_cameras(cameras); }, {"camera 1", "0 points"});
}

}  // namespace slipstream::fused_cameras_test
