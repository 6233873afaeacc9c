#include "calibrate/point_boards.h"

#include <cmath>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "base/numbers.h"
#include "slipstream/geometry_calibration.h"
#include "slipstream/named_scenes.h"
#include "tests/calibrate/virtual_views.h"
#include "tests/io/expect_error.h"

namespace slipstream::point_boards_test {

const CalibrationBoard board{.columns = 9, .rows = 6, .spacing = 20};

/// Poses of a board in front of the example scanner, as another program would list them.
std::vector<PosePoints> listed(int count, double noise, double unit = 1) {
  const BoardPlaces places = printed_places(board);
  std::vector<PosePoints> poses;
  for (const BoardView& view :
       virtual_views(example_scanner(), board, places, count, noise).views) {
    PosePoints pose{view.name, {}, view.camera, view.projector};
    for (const int place : view.places) pose.board.push_back(places[place] / unit);
    poses.push_back(pose);
  }
  return poses;
}

PointBoards boards_of(const std::vector<PosePoints>& poses,
                      const PointConventions& conventions = {}) {
  const Scanner scanner = example_scanner();
  return boards_of_points(poses, scanner.camera.size, scanner.projector.size, conventions);
}

GeometryCalibration calibrated(const PointBoards& boards) {
  const Scanner truth = example_scanner();
  return calibrate_geometry(boards.views, boards.places, boards.spacing, truth.camera.size,
                            truth.projector.size,
                            {.camera_coefficients = 5, .projector_coefficients = 5});
}

/// The errors of focal lengths and translation, in their standard deviations.
void expect_within_sigma(const GeometryCalibration& found, double most) {
  const Scanner truth = example_scanner();
  const Scanner& scanner = found.state.scanner;
  const auto& [camera, projector, rotation, translation] = found.deviation;
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_NEAR(scanner.translation[axis], truth.translation[axis], most * translation[axis]);
  }
  for (int axis = 0; axis < 2; ++axis) {
    EXPECT_NEAR(scanner.camera.intrinsic(axis, axis), truth.camera.intrinsic(axis, axis),
                most * camera.focal[axis]);
    EXPECT_NEAR(scanner.projector.intrinsic(axis, axis), truth.projector.intrinsic(axis, axis),
                most * projector.focal[axis]);
  }
}

TEST(PointBoards, GiveTheScannerWithinItsSigma) {
  const PointBoards boards = boards_of(listed(8, 0.05));
  EXPECT_EQ(boards.places.size(), 54U);
  EXPECT_DOUBLE_EQ(boards.spacing, 20);
  EXPECT_TRUE(boards.notes.empty()) << boards.notes.front();
  expect_within_sigma(calibrated(boards), 4);
}

TEST(PointBoards, MayLackThePixelsOfEitherDevice) {
  std::vector<PosePoints> poses = listed(8, 0.05);
  for (std::size_t pose = 0; pose < poses.size(); ++pose) {
    for (std::size_t i = pose % 3; i < 54; i += 3) poses[pose].camera[i] = {nan, nan};
    for (std::size_t i = (pose + 1) % 3; i < 54; i += 6) poses[pose].projector[i] = {nan, nan};
  }
  const GeometryCalibration found = calibrated(boards_of(poses));
  EXPECT_EQ(found.poses[0].lit, 27);
  expect_within_sigma(found, 4);
}

TEST(PointBoards, MayDifferFromPoseToPose) {
  std::vector<PosePoints> poses = listed(8, 0.05);
  for (std::size_t pose = 0; pose < poses.size(); ++pose) {
    // Other columns of the board, in another frame, and a board that moved along z.
    for (auto* list : {&poses[pose].camera, &poses[pose].projector}) {
      list->erase(list->begin(), list->begin() + static_cast<std::ptrdiff_t>(pose));
    }
    auto& places = poses[pose].board;
    places.erase(places.begin(), places.begin() + static_cast<std::ptrdiff_t>(pose));
    for (Eigen::Vector3d& place : places) place.z() = 25.0 * static_cast<double>(pose);
  }
  const PointBoards boards = boards_of(poses);
  EXPECT_EQ(boards.places.size(), 54U);
  expect_within_sigma(calibrated(boards), 4);
}

TEST(PointBoards, FindUnitAndRowsAndColumns) {
  const GeometryCalibration usual = calibrated(boards_of(listed(6, 0)));

  // 1. Metres.
  const PointBoards in_metres = boards_of(listed(6, 0, 1000));
  ASSERT_EQ(in_metres.notes.size(), 1U);
  EXPECT_NE(in_metres.notes[0].find("in metres"), std::string::npos);
  EXPECT_NEAR(calibrated(in_metres).state.scanner.translation.norm(),
              usual.state.scanner.translation.norm(), 1e-3);

  // 2. Squares, whose side is given.
  const PointBoards squares = boards_of(listed(6, 0, 20));
  ASSERT_EQ(squares.notes.size(), 1U);
  EXPECT_NE(squares.notes[0].find("`unit`"), std::string::npos);
  EXPECT_NEAR(boards_of(listed(6, 0, 20), {.unit = 20}).spacing, 20, 1e-9);

  // 3. Row and column of either device, or both, as a program for matrices gives them.
  for (const bool camera : {true, false}) {
    for (const bool projector : {true, false}) {
      std::vector<PosePoints> poses = listed(6, 0);
      for (PosePoints& pose : poses) {
        for (std::size_t i = 0; i < pose.camera.size(); ++i) {
          if (camera) std::swap(pose.camera[i].x(), pose.camera[i].y());
          if (projector) std::swap(pose.projector[i].x(), pose.projector[i].y());
        }
      }
      const PointBoards found =
          boards_of(poses, {.swaps_camera = camera, .swaps_projector = projector});
      EXPECT_EQ(found.views[3].camera, listed(6, 0)[3].camera);
      EXPECT_EQ(found.views[3].projector, listed(6, 0)[3].projector);
    }
  }
}

TEST(PointBoards, ExchangeRowsAndColumnsOnlyWhereThePointsSaySo) {
  // 1. Pixels that only so lie in the picture.
  std::vector<PosePoints> poses = listed(6, 0);
  for (PosePoints& pose : poses) {
    for (Eigen::Vector2d& pixel : pose.camera) std::swap(pixel.x(), pixel.y());
  }
  const Scanner scanner = example_scanner();
  double lowest = 0;
  for (const PosePoints& pose : poses) {
    for (const Eigen::Vector2d& pixel : pose.camera) lowest = std::max(lowest, pixel.y());
  }
  ASSERT_GT(lowest, 1.02 * scanner.camera.size.height);
  const PointBoards found = boards_of(poses);
  ASSERT_EQ(found.notes.size(), 1U);
  EXPECT_NE(found.notes[0].find("camera's pixels are row, column"), std::string::npos);

  // 2. Pixels in the middle, where either device may have them exchanged.
  for (PosePoints& pose : poses) {
    for (auto* pixels : {&pose.camera, &pose.projector}) {
      for (Eigen::Vector2d& pixel : *pixels) pixel = pixel / 4 + Eigen::Vector2d(100, 100);
    }
  }
  expect_error([&] { (void)boards_of(poses); }, {"`swap camera` or `swap projector`"});
}

TEST(PointBoards, RefuseWhatCannotBe) {
  std::vector<PosePoints> poses = listed(4, 0);
  for (Eigen::Vector2d& pixel : poses[1].projector) pixel *= 3;
  expect_error([&] { (void)boards_of(poses); }, {"projector lie outside its picture"});

  poses = listed(4, 0);
  for (PosePoints& pose : poses) {
    for (Eigen::Vector2d& pixel : pose.projector) pixel.x() = 1279 - pixel.x();
  }
  expect_error([&] { (void)boards_of(poses); }, {"mirror each other", "a picture is mirrored"});

  poses = listed(4, 0);
  poses[2].board[7].z() = 60;
  poses[2].board[40].z() = -50;
  expect_error([&] { (void)boards_of(poses); }, {"pose2", "not flat"});
  for (Eigen::Vector3d& place : poses[2].board) place.tail<2>().setZero();
  expect_error([&] { (void)boards_of(poses); }, {"pose2", "on a line"});

  // A pose without pairs is left out.
  poses = listed(4, 0);
  for (Eigen::Vector2d& pixel : poses[3].projector) pixel = {nan, nan};
  EXPECT_EQ(boards_of(poses).unused.at(0).name, "pose3");
}

}  // namespace slipstream::point_boards_test
