#include "calibrate/marker_pose.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "base/numbers.h"
#include "base/statistics.h"
#include "calibrate/board_corners.h"
#include "calibrate/reprojection.h"
#include "geometry/rotation.h"
#include "slipstream/named_scenes.h"
#include "slipstream/virtual_scanner.h"
#include "tests/io/expect_error.h"

namespace slipstream::marker_pose_test {

constexpr int pixels_per_cell = 40;

/// A printed marker whose black square has this side, mm.
Body sheet_with(Markers markers, int number, double side, const Scanner& scanner) {
  const Image<std::uint8_t> drawn = draw_marker(markers, number, pixels_per_cell);
  const double squares = static_cast<double>(drawn.width()) / pixels_per_cell - 2;  // less margins
  return printed_sheet(drawn, side / squares / pixels_per_cell, scanner);
}

/// The mean picture of a scan of these bodies.
Image<float> picture_of(const Scene& scene, const Scanner& scanner, std::uint64_t seed = 1) {
  const PatternSet patterns = pattern_set(Sequence{.projector = scanner.projector.size});
  const Photometry light{.ambient = 10, .noise_variance = 1.6, .bits = 8, .seed = seed};
  const FrameSet frames = take_scan(scanner, scene, patterns, light).frames;
  return fringe_free_pictures(frames, frames).mean;
}

TEST(MarkerPose, IsTheTrueOneWithinItsSigma) {
  const Scanner scanner = example_scanner({640, 480});
  constexpr double side = 60;
  Squares shifts, turns;
  std::vector<double> off, angles;

  Body sheet = sheet_with(Markers::april_36h11, 17, side, scanner);
  const auto& shape = std::get<Board>(sheet.shape);
  std::uint64_t seed = 1;
  for (const Eigen::Isometry3d& truth : board_poses(scanner, 20, shape.width, shape.height)) {
    sheet.pose = truth;
    const Image<float> picture = picture_of({sheet}, scanner, seed++);
    const std::vector<SeenMarker> seen = find_markers(Markers::april_36h11, picture);
    ASSERT_EQ(seen.size(), 1U);
    EXPECT_EQ(seen.front().number, 17);

    const MarkerPose found =
        marker_pose(Markers::april_36h11, seen.front(), side, picture, scanner.camera);
    const Eigen::Vector3d by = found.pose.translation() - truth.translation();
    const Eigen::Vector3d about = vector_of(truth.linear().transpose() * found.pose.linear());
    for (int i = 0; i < 3; ++i) {
      shifts.add(std::pow(by[i] / found.translation_deviation[i], 2));
      turns.add(std::pow(about[i] / found.rotation_deviation[i], 2));
    }
    off.push_back(by.norm());
    angles.push_back(about.norm());
  }

  EXPECT_GT(shifts.rms(), 0.5);
  EXPECT_LT(shifts.rms(), 1.2);
  EXPECT_GT(turns.rms(), 0.5);
  EXPECT_LT(turns.rms(), 1.2);
  EXPECT_LT(median(off), 0.1);
  EXPECT_LT(median(angles), 0.1 * degree);
}

TEST(MarkerPose, IsFoundInEachFamily) {
  const Scanner scanner = example_scanner({640, 480});
  for (const char* const name : {"36h11", "36h10", "25h9", "16h5", "4x4", "5x5", "6x6", "7x7"}) {
    const Markers markers = markers_named(name);
    EXPECT_EQ(name_of(markers), name);
    Body sheet = sheet_with(markers, 3, 60, scanner);
    sheet.pose = board_poses(scanner, 1, 90, 90).front();
    const Image<float> picture = picture_of({sheet}, scanner);
    const std::vector<SeenMarker> seen = find_markers(markers, picture);
    ASSERT_EQ(seen.size(), 1U) << name;
    EXPECT_EQ(seen.front().number, 3);
    const Eigen::Isometry3d pose =
        marker_pose(markers, seen.front(), 60, picture, scanner.camera).pose;
    EXPECT_LT((pose.translation() - sheet.pose.translation()).norm(), 0.3) << name;
    EXPECT_LT(angle_between(pose.linear(), sheet.pose.linear()), 0.3 * degree) << name;
  }
}

TEST(MarkerPose, IsRefusedWhereItIsUncertain) {
  const Scanner scanner = example_scanner({640, 480});
  EXPECT_TRUE(find_markers(Markers::april_36h11, Image<float>({640, 480}, 80)).empty());

  // A small one, whose bits are two pixels wide.
  Body sheet = sheet_with(Markers::april_36h11, 0, 60, scanner);
  sheet.pose = board_poses(scanner, 1, 90, 90).front();
  const Image<float> near = picture_of({sheet}, scanner);
  const SeenMarker seen = find_markers(Markers::april_36h11, near).at(0);
  SeenMarker small = seen;
  for (Eigen::Vector2d& corner : small.corners) corner = (corner + 4 * seen.corners[0]) / 5;
  expect_error([&] { (void)marker_pose(Markers::april_36h11, small, 60, near, scanner.camera); },
               {"pixels wide"});

  // Something in front of a part of a side.
  Image<float> covered = near;
  const Eigen::Vector2d middle = (seen.corners[0] + seen.corners[1]) / 2;
  for_each_pixel_in_order(covered.size(), [&](int column, int row) {
    if ((Eigen::Vector2d(column, row) - middle).norm() < 12) covered(column, row) = 5;
  });
  const Eigen::Isometry3d pose =
      marker_pose(Markers::april_36h11, seen, 60, covered, scanner.camera).pose;
  EXPECT_LT((pose.translation() - sheet.pose.translation()).norm(), 1);

  expect_error([&] { (void)marker_pose(Markers::april_36h11, seen, -1, near, scanner.camera); },
               {"side", "out of range"});
  expect_error([] { (void)markers_named("8x8"); }, {"36h11"});
  expect_error([] { (void)draw_marker(Markers::april_16h5, 30, 10); }, {"0 to 29"});
}

}  // namespace slipstream::marker_pose_test
