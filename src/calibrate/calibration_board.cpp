#include "slipstream/calibration_board.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "base/throw_if-inl.h"
#include "calibrate/charuco.h"
#include "calibrate/opencv.h"

namespace slipstream {
namespace {

constexpr std::array<std::string_view, 4> kinds{"chessboard", "circles", "charuco",
                                                "symmetric-circles"};  // in order

constexpr int white = 255;

cv::Mat drawn_chessboard(const CalibrationBoard& board, int side) {
  cv::Mat picture((board.rows + 3) * side, (board.columns + 3) * side, CV_8U, cv::Scalar(white));
  for_each_pixel_in_order({board.columns + 1, board.rows + 1}, [&](int column, int row) {
    if ((row + column) % 2 == 0) picture({(column + 1) * side, (row + 1) * side, side, side}) = 0;
  });

  return picture;
}

cv::Mat drawn_circles(const CalibrationBoard& board, int pixels_per_spacing) {
  const int across = board.kind == BoardKind::circles ? 2 * board.columns + 4 : board.columns + 3;
  cv::Mat picture((board.rows + 3) * pixels_per_spacing, across * pixels_per_spacing, CV_8U,
                  cv::Scalar(white));

  // OpenCV draws with subpixel accuracy from integers in 256ths of a pixel.
  constexpr int fraction_bits = 8;
  const auto fixed_point = [&](double pixels) {
    return static_cast<int>(std::lround(std::ldexp(pixels, fraction_bits)));
  };

  for (const Eigen::Vector3d& place : printed_places(board)) {
    // Places are relative to the picture's edge, pixels to their centres.
    const Eigen::Vector3d pixel =
        (place / board.spacing + Eigen::Vector3d::Constant(2)) * pixels_per_spacing -
        Eigen::Vector3d::Constant(0.5);
    cv::circle(picture, {fixed_point(pixel.x()), fixed_point(pixel.y())},
               fixed_point(diameter_of(board) / 2 * pixels_per_spacing), cv::Scalar(0), cv::FILLED,
               cv::LINE_AA, fraction_bits);
  }

  return picture;
}

cv::Mat drawn_charuco(const CalibrationBoard& board, int side) {
  cv::Mat picture = drawn_chessboard(board, side);
  const int width = cvRound(board.marker_side * side);
  const int margin = side + (side - width) / 2;
  const cv::aruco::ArucoDetector detector = marker_detector(board);

  for_each_pixel_in_order({board.columns + 1, board.rows + 1}, [&](int column, int row) {
    if ((row + column) % 2 == 0) return;

    const cv::Mat cells = marker_cells(detector.getDictionary(), marker_id(board, column, row));
    cv::resize(cells, picture({column * side + margin, row * side + margin, width, width}),
               {width, width}, 0, 0, cv::INTER_NEAREST);
  });

  return picture;
}

/// Error of a length read off a ruler, mm: a quarter of a division at either end.
constexpr double ruler_error = 0.3;

}  // namespace

std::string_view name_of(BoardKind kind) {
  return kinds.at(static_cast<std::size_t>(kind));
}

BoardKind board_kind_named(std::string_view name) {
  const auto found = std::ranges::find(kinds, name);
  if (found != kinds.end()) return static_cast<BoardKind>(found - kinds.begin());
  throw Error(
      fmt::format("board '{}': expected chessboard, circles, charuco or symmetric-circles", name));
}

void require_valid(const CalibrationBoard& board) {
  constexpr int most = 200;
  const int fewest = board.kind == BoardKind::charuco ? 2 : 3;
  const int columns = board.columns;
  const int rows = board.rows;

  throw_if(columns < fewest || rows < fewest || columns > most || rows > most,
           "board of {}x{} corners is out of range; {} to {} each way", columns, rows, fewest,
           most);

  const auto require = [](bool holds, const std::string& what, const char* range) {
    throw_if(!holds, "{} is out of range; {}", what, range);
  };
  require(board.spacing > 0 && std::isfinite(board.spacing),
          fmt::format("spacing {} mm", board.spacing), "more than 0");

  const double down = board.row_spacing.value_or(board.spacing);
  require(down > 0 && std::isfinite(down), fmt::format("spacing of rows {} mm", down),
          "more than 0");

  const double size = board.circle_diameter.value_or(diameter_of(board));
  const bool symmetric = board.kind == BoardKind::symmetric_circles;
  require(size > 0.1 && size < (symmetric ? 1 : 1.4),
          fmt::format("circle diameter {} spacings", size), symmetric ? "0.1 to 1" : "0.1 to 1.4");
  require(board.marker_side > 0.2 && board.marker_side < 1,
          fmt::format("marker side {} squares", board.marker_side), "0.2 to 1");
  require(board.marker_bits >= 4 && board.marker_bits <= 7,
          fmt::format("marker bits {}", board.marker_bits), "4 to 7");

  const int markers = (columns + 1) * (rows + 1) / 2;
  throw_if(board.kind == BoardKind::charuco && markers > charuco_dictionary_size,
           "a ChArUco board of {}x{} corners needs {} markers; OpenCV has {}: use fewer corners",
           columns, rows, markers, charuco_dictionary_size);
}

int place_count(const CalibrationBoard& board) {
  return board.columns * board.rows;
}

BoardPlaces printed_places(const CalibrationBoard& board) {
  const double down = board.row_spacing.value_or(board.spacing);

  BoardPlaces places;
  for_each_pixel_in_order({board.columns, board.rows}, [&](int column, int row) {
    const int x = board.kind == BoardKind::circles ? 2 * column + row % 2 : column;
    places.emplace_back(x * board.spacing, row * down, 0);
  });
  return places;
}

Image<std::uint8_t> draw_board(const CalibrationBoard& board, int pixels_per_spacing) {
  require_valid(board);
  throw_if(pixels_per_spacing < 8 || pixels_per_spacing > 1000,
           "{} pixels for each spacing of the board is out of range; 8 to 1000",
           pixels_per_spacing);
  if (board.row_spacing) throw Error("a board to print has one spacing; omit the row spacing");

  // In the order of kinds.
  constexpr std::array draw{drawn_chessboard, drawn_circles, drawn_charuco, drawn_circles};
  return image_from<std::uint8_t>(
      draw.at(static_cast<std::size_t>(board.kind))(board, pixels_per_spacing));
}

std::vector<Finding> findings_of_ruler(const CalibrationBoard& board,
                                       const MeasuredPrint& measured) {
  const Eigen::Array2d is(measured.along_row, measured.along_column);
  throw_if(!((is > 0).all() && is.isFinite().all()),
           "`measured {:g}x{:g}` mm: both lengths must be above 0", measured.along_row,
           measured.along_column);

  // The printed lengths of a row and a column; a shifted last row of circles ends further right.
  const Eigen::Vector3d last = printed_places(board).back();
  const double shifted = board.kind == BoardKind::circles && board.rows % 2 == 0 ? 1 : 0;
  const Eigen::Array2d configured(last.x() - shifted * board.spacing, last.y()),
      scale = is / configured;

  if (((is - configured).abs() <= ruler_error).all()) return {};

  const double row_spacing = board.row_spacing.value_or(board.spacing);
  Finding finding{
      .kind = FindingKind::wrong_print_size,
      .what = fmt::format("the print has the wrong size, off by over {:g} mm", ruler_error),
      .evidence = {{"rows too long by", 100 * (scale[0] - 1), "%",
                    100 * ruler_error / configured[0]},
                   {"columns too long by", 100 * (scale[1] - 1), "%",
                    100 * ruler_error / configured[1]}},
      .causes = {{CauseKind::board_print, "a print of the wrong scale, such as by 'fit to page'"}}};

  // One scale fits both lengths within the ruler's error.
  const double common = is.sum() / configured.sum();
  const bool stretched = ((is - common * configured).abs() > ruler_error).any();

  const auto use = [](const char* setting, const std::string& value) {
    return change_settings("use", {{setting, value}});
  };
  const auto spacings = [&](double across, double down) {
    return fmt::format("{:.4g}x{:.4g}", across * board.spacing, down * row_spacing);
  };

  if (((is.reverse() - configured).abs() <= ruler_error).all()) {
    finding.causes.front().text = "the lengths of row and column are swapped";
    finding.remedies = {use("measured", fmt::format("{:g}x{:g}", is[1], is[0]))};
  } else if (stretched) {
    finding.causes.front().text =
        "a print stretched along one axis, or of the wrong scale along each";
    finding.remedies = {use("spacing", spacings(scale[0], scale[1]))};
  } else if (board.row_spacing) {
    finding.remedies = {use("spacing", spacings(common, common))};
  } else {
    finding.remedies = {use("spacing", fmt::format("{:.4g}", common * board.spacing))};
  }

  return {finding};
}

}  // namespace slipstream
