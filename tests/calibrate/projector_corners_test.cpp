#include "calibrate/projector_corners.h"

#include <cmath>
#include <random>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "slipstream/frame_set.h"

namespace slipstream::projector_corners_test {

const Size size{120, 100};

Eigen::Vector2d truth_at(const Eigen::Vector2d& pixel) {
  Eigen::Matrix3d homography;
  homography << 1.7, 0.2, 300, -0.15, 1.6, 200, 4e-4, -3e-4, 1;
  return (homography * pixel.homogeneous()).hnormalized();
}

ProjectorMap true_map() {
  ProjectorMap map{Image<double>(size), Image<double>(size), Image<double>(size, 1)};
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const Eigen::Vector2d pixel = truth_at({column, row});
      map.x(column, row) = pixel.x();
      map.y(column, row) = pixel.y();
    }
  }
  return map;
}

const std::vector<Eigen::Vector2d> corners{{40.3, 50.6}, {60.1, 50.2}, {40.4, 70.9}};

TEST(ProjectorCorners, OfAPlaneAreExact) {
  const auto found = projector_corners(true_map(), corners, 0.7);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    EXPECT_LT((found[i].pixel - truth_at(corners[i])).norm(), 1e-9);
    constexpr double step = 1e-4;  // pixels
    for (int axis = 0; axis < 2; ++axis) {
      const Eigen::Vector2d moved = corners[i] + step * Eigen::Vector2d::Unit(axis);
      const Eigen::Vector2d slope = (truth_at(moved) - truth_at(corners[i])) / step;
      EXPECT_LT((found[i].slope.col(axis) - slope).norm(), 1e-5);
    }
  }
}

TEST(ProjectorCorners, WrongFringesAndUnreliablePixelsDoNotMoveThem) {
  ProjectorMap map = true_map();
  std::mt19937 random(3);
  for (std::size_t i = 0; i < map.x.pixel_count(); ++i) {
    if (random() % 5 < 2) map.x.begin()[i] += 300;  // one fringe off
    if (random() % 5 == 0) {
      map.weight.begin()[i] = 0;
      map.y.begin()[i] = std::nan("");
    }
  }
  const auto found = projector_corners(map, corners, 0.7);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    EXPECT_LT((found[i].pixel - truth_at(corners[i])).norm(), 1e-6);
  }
}

TEST(ProjectorCorners, AreNoneWhereTooLittleIsLit) {
  ProjectorMap map = true_map();
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < 50; ++column) map.weight(column, row) = 0;
  }
  const auto found = projector_corners(map, corners, 0.5);
  EXPECT_FALSE(found[0].pixel.allFinite());
  EXPECT_TRUE(found[1].pixel.allFinite());
  EXPECT_FALSE(found[2].pixel.allFinite());
}

TEST(ProjectorCorners, ReliableIsWhatBothScansLightAndNeitherSaturates) {
  const FrameSet frames(FrameSet::Images8{Image<std::uint8_t>({3, 1}, 100)});
  FrameSet::Images8 bright{Image<std::uint8_t>({3, 1}, 100)};
  bright[0](2, 0) = 255;
  BasicMaps<double> along_x, along_y;
  along_x.coordinate = along_y.coordinate = Image<double>({3, 1}, 0.25);
  along_x.modulation = Image<double>({3, 1}, 40);
  along_y.modulation = Image<double>({3, 1}, 20);
  along_y.modulation(0, 0) = 3;
  const ProjectorMap map =
      projector_map(frames, along_x, FrameSet(std::move(bright)), along_y, {400, 200}, 5);
  EXPECT_EQ(map.weight(0, 0), 0);
  EXPECT_EQ(map.weight(1, 0), 400);
  EXPECT_EQ(map.weight(2, 0), 0);
  EXPECT_EQ(map.x(1, 0), 100);
  EXPECT_EQ(map.y(1, 0), 50);
}

TEST(ProjectorCorners, EachScanIsMeasuredByItsOwnFullScale) {
  const FrameSet of_8_bits(FrameSet::Images8{Image<std::uint8_t>({1, 1}, 100)});
  const FrameSet of_16_bits(FrameSet::Images16{Image<std::uint16_t>({1, 1}, 25700)}, 16);
  BasicMaps<double> along_x, along_y;
  along_x.coordinate = along_y.coordinate = Image<double>({1, 1}, 0.25);
  along_x.modulation = Image<double>({1, 1}, 40);
  along_y.modulation = Image<double>({1, 1}, 20 * 257);
  EXPECT_DOUBLE_EQ(
      projector_map(of_8_bits, along_x, of_16_bits, along_y, {400, 200}, 5).weight(0, 0), 400);
  EXPECT_DOUBLE_EQ(
      projector_map(of_16_bits, along_y, of_8_bits, along_x, {400, 200}, 5).weight(0, 0), 400);
}

}  // namespace slipstream::projector_corners_test
