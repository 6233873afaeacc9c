#include "slipstream/calibration_board.h"

#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/io/expect_error.h"

namespace slipstream::calibration_board_test {

TEST(CalibrationBoard, PlacesAreWhereItIsPrinted) {
  const auto chess = printed_places({.columns = 4, .rows = 3, .spacing = 5});
  ASSERT_EQ(chess.size(), 12U);
  EXPECT_EQ(chess[5], Eigen::Vector3d(5, 5, 0));
  EXPECT_EQ(chess[11], Eigen::Vector3d(15, 10, 0));
  const auto circles =
      printed_places({.kind = BoardKind::circles, .columns = 4, .rows = 3, .spacing = 5});
  EXPECT_EQ(circles[1], Eigen::Vector3d(10, 0, 0));
  EXPECT_EQ(circles[4], Eigen::Vector3d(5, 5, 0));
}

TEST(CalibrationBoard, IsDrawnWithAMarginOfOneSpacing) {
  const Image<std::uint8_t> chess = draw_board({.columns = 4, .rows = 3}, 10);
  EXPECT_EQ(chess.size(), (Size{70, 60}));
  EXPECT_EQ(chess(9, 9), 255);
  EXPECT_EQ(chess(10, 10), 0);
  EXPECT_EQ(chess(20, 10), 255);
  EXPECT_EQ(chess(60, 50), 255);
  EXPECT_EQ(draw_board({.kind = BoardKind::charuco, .columns = 4, .rows = 3}, 20).size(),
            (Size{140, 120}));
  const Image<std::uint8_t> circles =
      draw_board({.kind = BoardKind::circles, .columns = 4, .rows = 3}, 20);
  EXPECT_EQ(circles.size(), (Size{240, 120}));
  EXPECT_EQ(circles(40, 40), 0);
  EXPECT_EQ(circles(60, 40), 255);
  EXPECT_EQ(circles(60, 60), 0);
}

/// A square's cells, 10 x 10: '#' dark, '.' bright.
std::vector<std::string> cells(const Image<std::uint8_t>& drawn, int column, int row) {
  constexpr int cell = 2;
  std::vector<std::string> lines(10, std::string(10, '.'));
  for_each_pixel_in_order({10, 10}, [&](int x, int y) {
    const int right = (column + 1) * 20 + cell * x, down = (row + 1) * 20 + cell * y;
    if (drawn(right, down) == 0) lines[y][x] = '#';
  });
  return lines;
}

// OpenCV's own boards with an even number of rows start with a bright square before 4.6.
TEST(CalibrationBoard, OfMarkersDoesNotDependOnTheVersionOfOpenCv) {
  const auto drawn =
      draw_board({.kind = BoardKind::charuco, .columns = 2, .rows = 3, .marker_side = 0.6}, 20);
  EXPECT_EQ(cells(drawn, 0, 0), std::vector<std::string>(10, "##########"));
  const std::vector<std::string> first{"..........", "..........", "..######..", "..#.#..#..",
                                       "..##.#.#..", "..###..#..", "..###.##..", "..######..",
                                       "..........", ".........."};
  const std::vector<std::string> last{"..........", "..........", "..######..", "..##...#..",
                                      "..#.##.#..", "..#..###..", "..#..#.#..", "..######..",
                                      "..........", ".........."};
  EXPECT_EQ(cells(drawn, 1, 0), first);
  EXPECT_EQ(cells(drawn, 2, 3), last);
}

TEST(CalibrationBoard, ThatCannotBeIsToldInOneLine) {
  expect_error([] { require_valid(CalibrationBoard{.columns = 1}); }, {"1x9", "3 to 200"});
  expect_error([] { require_valid(CalibrationBoard{.spacing = 0}); }, {"spacing 0", "more than 0"});
  expect_error([] { require_valid(CalibrationBoard{.circle_diameter = 3}); }, {"circle diameter"});
  expect_error([] { require_valid(CalibrationBoard{.marker_side = 2}); }, {"marker side 2"});
  expect_error([] { require_valid(CalibrationBoard{.marker_bits = 9}); }, {"marker bits 9"});
  expect_error([] { (void)board_kind_named("hexagons"); }, {"hexagons", "charuco"});
  expect_error([] { (void)draw_board({}, 2); }, {"2 pixels", "8 to 1000"});
  expect_error(
      [] {
        require_valid(CalibrationBoard{.kind = BoardKind::charuco, .columns = 100, .rows = 100});
      },
      {"markers", "1000"});
}

}  // namespace slipstream::calibration_board_test
