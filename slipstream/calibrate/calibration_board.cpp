#include "slipstream/calibrate/calibration_board.h"

#include <array>
#include <cmath>
#include <utility>

#include <Eigen/Core>
#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/calibrate/opencv.h"

namespace slipstream {
namespace {

constexpr std::array<std::pair<BoardKind, std::string_view>, 3> kinds{
    {{BoardKind::chessboard, "chessboard"},
     {BoardKind::circles, "circles"},
     {BoardKind::charuco, "charuco"}}};

constexpr int white = 255;

cv::Mat drawn_chessboard(const CalibrationBoard& board, int side) {
  cv::Mat picture((board.rows + 3) * side, (board.columns + 3) * side, CV_8U, cv::Scalar(white));
  for (int row = 0; row <= board.rows; ++row) {
    for (int column = 0; column <= board.columns; ++column) {
      if ((row + column) % 2 != 0) continue;
      picture(cv::Rect((column + 1) * side, (row + 1) * side, side, side)) = 0;
    }
  }
  return picture;
}

cv::Mat drawn_circles(const CalibrationBoard& board, int pixels_per_spacing) {
  cv::Mat picture((board.rows + 3) * pixels_per_spacing,
                  (2 * board.columns + 4) * pixels_per_spacing, CV_8U, cv::Scalar(white));
  constexpr int fraction_bits = 8;
  const auto fixed_point = [&](double pixels) {
    return static_cast<int>(std::lround(std::ldexp(pixels, fraction_bits)));
  };
  const double radius = board.circle_diameter / 2;
  for (const Eigen::Vector3d& place : printed_places(board)) {
    // Places are counted from the picture's edge, pixels from their centres.
    const Eigen::Vector3d pixel =
        (place / board.spacing + Eigen::Vector3d::Constant(2)) * pixels_per_spacing -
        Eigen::Vector3d::Constant(0.5);
    cv::circle(picture, {fixed_point(pixel.x()), fixed_point(pixel.y())},
               fixed_point(radius * pixels_per_spacing), cv::Scalar(0), cv::FILLED, cv::LINE_AA,
               fraction_bits);
  }
  return picture;
}

cv::Mat drawn_charuco(const CalibrationBoard& board, int side) {
  cv::Mat picture;
  charuco_of(board)->draw({(board.columns + 3) * side, (board.rows + 3) * side}, picture, side, 1);
  return picture;
}

/// What a length read off a ruler may be off, mm: a quarter of a division at either end.
constexpr double ruler_error = 0.3;

/// From the first to the last corner of a row and of a column, mm, as said.
Eigen::Array2d said_lengths(const CalibrationBoard& board) {
  const Eigen::Vector3d last = printed_places(board).back();
  const double shifted = board.kind == BoardKind::circles && board.rows % 2 == 0 ? 1 : 0;
  return {last.x() - shifted * board.spacing, last.y()};
}

}  // namespace

std::string_view name_of(BoardKind kind) {
  for (const auto& [known, name] : kinds) {
    if (known == kind) return name;
  }
  return "?";
}

BoardKind board_kind_named(std::string_view name) {
  for (const auto& [kind, known] : kinds) {
    if (known == name) return kind;
  }
  throw Error(fmt::format("board '{}' is not known; it is chessboard, circles or charuco", name));
}

void require_valid(const CalibrationBoard& board) {
  constexpr int most = 200;
  const int fewest = board.kind == BoardKind::charuco ? 2 : 3;
  if (board.columns < fewest || board.rows < fewest || board.columns > most || board.rows > most) {
    throw Error(fmt::format("board of {}x{} corners is out of range; {} to {} each way",
                            board.columns, board.rows, fewest, most));
  }
  if (!(board.spacing > 0 && std::isfinite(board.spacing))) {
    throw Error(fmt::format("spacing {} mm is out of range; more than 0", board.spacing));
  }
  if (board.row_spacing && !(*board.row_spacing > 0 && std::isfinite(*board.row_spacing))) {
    throw Error(
        fmt::format("spacing of rows {} mm is out of range; more than 0", *board.row_spacing));
  }
  if (!(board.circle_diameter > 0.1 && board.circle_diameter < 1.4)) {
    throw Error(fmt::format("circle diameter {} spacings is out of range; 0.1 to 1.4",
                            board.circle_diameter));
  }
  if (!(board.marker_side > 0.2 && board.marker_side < 1)) {
    throw Error(fmt::format("marker side {} squares is out of range; 0.2 to 1", board.marker_side));
  }
  if (board.marker_bits < 4 || board.marker_bits > 7) {
    throw Error(fmt::format("marker bits {} is out of range; 4 to 7", board.marker_bits));
  }
  const int markers = (board.columns + 1) * (board.rows + 1) / 2;
  if (board.kind == BoardKind::charuco && markers > charuco_dictionary_size) {
    throw Error(fmt::format("a ChArUco board of {}x{} corners needs {} markers; there are {}",
                            board.columns, board.rows, markers, charuco_dictionary_size));
  }
}

int place_count(const CalibrationBoard& board) {
  return board.columns * board.rows;
}

std::vector<Eigen::Vector3d> printed_places(const CalibrationBoard& board) {
  const double down = board.row_spacing.value_or(board.spacing);
  std::vector<Eigen::Vector3d> places;
  for (int row = 0; row < board.rows; ++row) {
    for (int column = 0; column < board.columns; ++column) {
      const int x = board.kind == BoardKind::circles ? 2 * column + row % 2 : column;
      places.emplace_back(x * board.spacing, row * down, 0);
    }
  }
  return places;
}

Image<std::uint8_t> draw_board(const CalibrationBoard& board, int pixels_per_spacing) {
  require_valid(board);
  if (pixels_per_spacing < 8 || pixels_per_spacing > 1000) {
    throw Error(fmt::format("{} pixels for each spacing of the board is out of range; 8 to 1000",
                            pixels_per_spacing));
  }
  if (board.row_spacing) throw Error("a board that is drawn has one spacing, not two");
  switch (board.kind) {
    case BoardKind::circles:
      return image_from<std::uint8_t>(drawn_circles(board, pixels_per_spacing));
    case BoardKind::charuco:
      return image_from<std::uint8_t>(drawn_charuco(board, pixels_per_spacing));
    case BoardKind::chessboard:
      break;
  }
  return image_from<std::uint8_t>(drawn_chessboard(board, pixels_per_spacing));
}

std::vector<Finding> findings_of_ruler(const CalibrationBoard& board,
                                       const MeasuredPrint& measured) {
  const Eigen::Array2d is(measured.along_row, measured.along_column);
  if (!((is > 0).all() && is.isFinite().all())) {
    throw Error(fmt::format("measured {:g}x{:g} mm is out of range; both lengths are above 0",
                            measured.along_row, measured.along_column));
  }
  const Eigen::Array2d said = said_lengths(board), scale = is / said;
  if (((is - said).abs() <= ruler_error).all()) return {};
  const double row_spacing = board.row_spacing.value_or(board.spacing);
  Finding finding{.what = "the print is not as large as said",
                  .evidence = {{"rows, % too long", 100 * (scale[0] - 1)},
                               {"columns, % too long", 100 * (scale[1] - 1)}},
                  .likely = "a print of the wrong scale, such as by 'fit to page'",
                  .advice = ""};
  // One scale fits both lengths to what the ruler may be off.
  const double common = is.sum() / said.sum();
  const bool stretched = ((is - common * said).abs() > ruler_error).any();
  if (((is.reverse() - said).abs() <= ruler_error).all()) {
    finding.likely = "the lengths of row and column were exchanged";
    finding.advice = fmt::format("give --measured {:g}x{:g}", is[1], is[0]);
  } else if (stretched) {
    finding.likely = "a print stretched along one axis, or of the wrong scale along each";
    finding.advice = fmt::format("give --spacing {:.4g}x{:.4g}", scale[0] * board.spacing,
                                 scale[1] * row_spacing);
  } else if (board.row_spacing) {
    finding.advice =
        fmt::format("give --spacing {:.4g}x{:.4g}", common * board.spacing, common * row_spacing);
  } else {
    finding.advice = fmt::format("give --spacing {:.4g}", common * board.spacing);
  }
  return {finding};
}

}  // namespace slipstream
