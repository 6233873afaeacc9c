#include "calibrate/board_corners.h"

#include <cmath>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "slipstream/frame_set.h"
#include "tests/io/expect_error.h"

namespace slipstream::board_corners_test {

constexpr int side = 20;  // spacing, pixels

/// Picture of a board and its true corners.
struct Picture {
  FringeFreePictures seen;
  std::vector<Eigen::Vector2d> truth;
};

/// `tilt`: in perspective, a place at (x, y) pixels from the middle, along the board, is seen at
/// (x, y) / (1 - tilt x).
Picture picture_of(const CalibrationBoard& board, double turn, Size size = {480, 400},
                   double tilt = 0) {
  constexpr int fine = 4;  // samples along each side of a pixel
  const Image<std::uint8_t> drawn = draw_board(board, side * fine);
  const Eigen::Vector2d middle(size.width / 2.0 - 0.5, size.height / 2.0 - 0.5);
  const Eigen::Rotation2D<double> rotation(turn);
  Picture picture{{Image<float>(size), Image<float>(size)}, {}};
  const auto grey_at = [&](const Eigen::Vector2d& pixel) -> double {
    const Eigen::Vector2d seen = rotation.inverse() * (pixel - middle);
    const Eigen::Vector2d on_board = seen / (1 + tilt * seen.x()) * fine;
    const double column = std::floor(on_board.x() + drawn.width() / 2.0);
    const double row = std::floor(on_board.y() + drawn.height() / 2.0);
    const bool inside = column >= 0 && row >= 0 && column < drawn.width() && row < drawn.height();
    return inside ? 30 + 0.7 * drawn(static_cast<int>(column), static_cast<int>(row)) : 120.0;
  };
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      double sum = 0;
      for (int sample = 0; sample < fine * fine; ++sample) {
        const Eigen::Vector2d offset((sample % fine + 0.5) / fine - 0.5,
                                     (sample / fine + 0.5) / fine - 0.5);
        sum += grey_at(Eigen::Vector2d(column, row) + offset);
      }
      picture.seen.mean(column, row) = static_cast<float>(sum / (fine * fine));
    }
  }
  picture.seen.brightest = picture.seen.mean;
  // The first place, their origin, is two spacings from the edge of the sheet.
  const Eigen::Vector2d first(2.0 * side - drawn.width() / 2.0 / fine,
                              2.0 * side - drawn.height() / 2.0 / fine);
  for (const Eigen::Vector3d& place : printed_places(board)) {
    const Eigen::Vector2d on_board = first + place.head<2>() / board.spacing * side;
    picture.truth.emplace_back(middle + rotation * on_board / (1 - tilt * on_board.x()));
  }
  return picture;
}

void expect_found(const CalibrationBoard& board, const Picture& picture, double tolerance) {
  const std::optional<BoardCorners> found = find_board(board, picture.seen);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->pixels.size(), static_cast<std::size_t>(place_count(board)));
  for (std::size_t i = 0; i < found->pixels.size(); ++i) {
    const Eigen::Vector2d& truth = picture.truth[static_cast<std::size_t>(found->places[i])];
    EXPECT_LT((found->pixels[i] - truth).norm(), tolerance)
        << found->detector << ", corner " << i << " at " << found->pixels[i].transpose() << ", not "
        << truth.transpose();
  }
}

TEST(BoardCorners, OfAChessboardAreFoundToAFractionOfAPixel) {
  const CalibrationBoard board{.columns = 9, .rows = 7};
  for (const double turn : {0.0, 0.2, -0.6, 1.0}) expect_found(board, picture_of(board, turn), 0.1);
}

/// A chessboard without sampling artefacts: each edge is a smooth function.
Picture smooth_picture_of(const CalibrationBoard& board, double turn) {
  const Size size{480, 400};
  const Eigen::Vector2d middle(size.width / 2.0 - 0.5, size.height / 2.0 - 0.5);
  const Eigen::Rotation2D<double> rotation(turn);
  Picture picture{{Image<float>(size, 200), {}}, {}};
  const Eigen::Vector2d last(board.columns - 1, board.rows - 1);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const Eigen::Array2d at =
          rotation.inverse() * (Eigen::Vector2d(column, row) - middle) / side + last / 2;
      if ((at < -1).any() || (at > last.array() + 1).any()) continue;
      const Eigen::Array2d edges = (6 * (std::numbers::pi * at).sin()).tanh();
      picture.seen.mean(column, row) = static_cast<float>(110 + 90 * edges.prod());
    }
  }
  picture.seen.brightest = picture.seen.mean;
  for (const Eigen::Vector3d& place : printed_places(board)) {
    picture.truth.emplace_back(middle +
                               rotation * (place.head<2>() / board.spacing - last / 2) * side);
  }
  return picture;
}

TEST(BoardCorners, OfAChessboardAreNotDrawnToThePixelGrid) {
  for (const double turn : {0.1, 0.2, 0.3, -0.25}) {
    expect_found({.columns = 9, .rows = 7}, smooth_picture_of({.columns = 9, .rows = 7}, turn),
                 0.003);
  }
}

TEST(BoardCorners, OfACircleGridAreFoundToAFractionOfAPixel) {
  const CalibrationBoard board{.kind = BoardKind::circles, .columns = 4, .rows = 9};
  for (const double turn : {0.0, 0.2}) expect_found(board, picture_of(board, turn), 0.15);
}

TEST(BoardCorners, OfASymmetricGridAreFoundToAFractionOfAPixel) {
  const CalibrationBoard board{.kind = BoardKind::symmetric_circles, .columns = 9, .rows = 7};
  for (const double turn : {0.0, 0.2, -0.6}) expect_found(board, picture_of(board, turn), 0.15);
}

// The ellipse that a tilted circle becomes has another centre.
TEST(BoardCorners, OfTiltedCirclesAreTheirCentres) {
  const CalibrationBoard board{.kind = BoardKind::symmetric_circles, .columns = 9, .rows = 7};
  expect_found(board, picture_of(board, 0, {480, 400}, 0.004), 0.15);
}

TEST(BoardCorners, OfWhiteCirclesAreThoseOfDarkOnes) {
  for (const BoardKind kind : {BoardKind::circles, BoardKind::symmetric_circles}) {
    const CalibrationBoard board{.kind = kind, .columns = 4, .rows = 9};
    Picture picture = picture_of(board, 0.2);
    for (Image<float>* seen : {&picture.seen.mean, &picture.seen.brightest}) {
      for (float& level : *seen) level = 255 - level;
    }
    expect_found(board, picture, 0.15);
  }
}

TEST(BoardCorners, OfACharucoBoardAreFoundWhereItIsInView) {
  const CalibrationBoard board{.kind = BoardKind::charuco, .columns = 9, .rows = 7};
  for (const double turn : {0.0, 0.2, 2.5}) expect_found(board, picture_of(board, turn), 0.2);
  const CalibrationBoard odd{.kind = BoardKind::charuco, .columns = 10, .rows = 8};
  expect_found(odd, picture_of(odd, 0.2), 0.2);

  const Picture cut = picture_of(board, 0.1, {160, 150});
  const std::optional<BoardCorners> found = find_board(board, cut.seen);
  ASSERT_TRUE(found);
  EXPECT_GE(found->pixels.size(), 15U);
  EXPECT_LT(found->pixels.size(), 63U);
  for (std::size_t i = 0; i < found->pixels.size(); ++i) {
    const Eigen::Vector2d& truth = cut.truth[static_cast<std::size_t>(found->places[i])];
    EXPECT_LT((found->pixels[i] - truth).norm(), 0.3);
  }
}

TEST(BoardCorners, ABoardOfAnotherSizeIsToldByItsSize) {
  const Picture picture = picture_of({.columns = 9, .rows = 7}, 0.1);
  EXPECT_FALSE(find_board({.columns = 9, .rows = 8}, picture.seen));
  EXPECT_EQ(chessboard_size(picture.seen), (Size{9, 7}));
  // A smaller board found inside it must be recognised as part of a larger one: the detector finds
  // 5x3 adjacent corners, 5x4 that leave out every second one, and 6x3 of single and double steps.
  for (const auto& [columns, rows] : {std::pair(8, 7), std::pair(9, 6), std::pair(5, 3),
                                      std::pair(5, 4), std::pair(9, 4), std::pair(6, 3)}) {
    const CalibrationBoard smaller{.columns = columns, .rows = rows};
    try {
      EXPECT_FALSE(find_board(smaller, picture.seen));
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("`corners`"), std::string::npos);
    }
  }
}

TEST(BoardCorners, NoBoardIsNothing) {
  const Picture picture = picture_of({.columns = 5, .rows = 4}, 0.1);
  EXPECT_FALSE(find_board({.columns = 9, .rows = 7}, picture.seen));
  for (const BoardKind kind : {BoardKind::chessboard, BoardKind::circles, BoardKind::charuco}) {
    const FringeFreePictures grey{Image<float>({200, 150}, 90), Image<float>({200, 150}, 90)};
    EXPECT_FALSE(find_board({.kind = kind, .columns = 5, .rows = 5}, grey));
  }
}

TEST(BoardCorners, MeanAndMaximumAreOverAllFrames) {
  using Images = FrameSet::Images8;
  const FrameSet x(Images{Image<std::uint8_t>({2, 1}, 10), Image<std::uint8_t>({2, 1}, 30)});
  const FrameSet y(FrameSet::Images16{Image<std::uint16_t>({2, 1}, 4095)}, 12);
  const FringeFreePictures pictures = fringe_free_pictures(x, y);
  EXPECT_FLOAT_EQ(pictures.mean(1, 0), (10 + 30 + 255) / 3.0F);
  EXPECT_FLOAT_EQ(pictures.brightest(0, 0), 255);
  const FrameSet other(Images{Image<std::uint8_t>({3, 1}, 10)});
  expect_error([&] { (void)fringe_free_pictures(x, other); }, {"2x1", "3x1"});
}

}  // namespace slipstream::board_corners_test
