#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slipstream/check.h"
#include "slipstream/image.h"

namespace slipstream {

enum class BoardKind {
  chessboard,         ///< must be fully visible
  circles,            ///< asymmetric grid of circles, dark on white or white on dark; fully visible
  charuco,            ///< chessboard with a marker in each bright square; may be partly out of view
  symmetric_circles,  ///< the same circles in rows and columns, none shifted
};

/// "chessboard", "circles", "charuco", "symmetric-circles".
std::string_view name_of(BoardKind kind);

/// Throws Error for an unknown name.
BoardKind board_kind_named(std::string_view name);

/// Places on a board, or measured points, mm.
using BoardPlaces = std::vector<Eigen::Vector3d>;

/// Places in a device's picture.
using PixelPlaces = std::vector<Eigen::Vector2d>;

/// A flat calibration board.
struct CalibrationBoard {
  BoardKind kind = BoardKind::chessboard;
  int columns = 13;     ///< corners between squares in a row; circles in a row
  int rows = 9;         ///< rows of corners; rows of circles, of `circles` every second one shifted
  double spacing = 10;  ///< mm: side of a square; the distance from row to row of circles, which of
                        ///< `circles` is half the distance in a row
  /// mm between rows of a stretched print; nullopt: `spacing`.
  std::optional<double> row_spacing{};
  std::optional<double> circle_diameter{};  ///< in spacings; default: see diameter_of
  double marker_side = 0.75;                ///< in squares
  int marker_bits = 4;                      ///< of the ArUco dictionary: 4, 5, 6 or 7 squared
};

/// Throws Error with the first value out of range.
void require_valid(const CalibrationBoard& board);

/// Whether the places are circles.
inline bool has_circles(const CalibrationBoard& board) {
  return board.kind == BoardKind::circles || board.kind == BoardKind::symmetric_circles;
}

/// The diameter of a circle, in spacings: by default 0.8, and 0.5 in a symmetric grid.
inline double diameter_of(const CalibrationBoard& board) {
  return board.circle_diameter.value_or(board.kind == BoardKind::symmetric_circles ? 0.5 : 0.8);
}

/// Number of corners or circles.
int place_count(const CalibrationBoard& board);

/// Nominal corners (centres of circles), row by row, mm, Z = 0.
BoardPlaces printed_places(const CalibrationBoard& board);

/// The board to print, dark on white, with a white margin of one spacing. Throws Error unless a
/// spacing has 8 to 1000 pixels, and for a board with `row_spacing`.
Image<std::uint8_t> draw_board(const CalibrationBoard& board, int pixels_per_spacing);

/// Lengths read off a print with a ruler, mm: first to last corner of a row and of a column.
struct MeasuredPrint {
  double along_row = 0;
  double along_column = 0;
};

/// Checks scale and stretch of the print within a ruler's accuracy. Frames cannot reveal the scale:
/// a calibration of any scale fits them equally well. The advice names the right spacing. Throws
/// Error unless both lengths are above 0.
std::vector<Finding> findings_of_ruler(const CalibrationBoard& board,
                                       const MeasuredPrint& measured);

}  // namespace slipstream
