#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slipstream/base/image.h"
#include "slipstream/check/finding.h"

namespace slipstream {

enum class BoardKind {
  chessboard,  ///< seen whole
  circles,     ///< asymmetric grid of dark circles, seen whole
  charuco,     ///< chessboard with a marker in each bright square; may be partly out of view
};

/// "chessboard", "circles", "charuco".
std::string_view name_of(BoardKind kind);

/// The kind of that name; throws Error for any other.
BoardKind board_kind_named(std::string_view name);

/// Places on a board, mm, or points that are measured.
using BoardPlaces = std::vector<Eigen::Vector3d>;
/// Places in a device's picture.
using PixelPlaces = std::vector<Eigen::Vector2d>;

/// A flat board with places on it that are known and found in a picture.
struct CalibrationBoard {
  BoardKind kind = BoardKind::chessboard;
  int columns = 13;     ///< corners between squares in a row; circles in a row
  int rows = 9;         ///< rows of corners; rows of circles, every second one shifted
  double spacing = 10;  ///< mm: side of a square; for circles half the distance in a row, which is
                        ///< the distance from row to row
  /// mm from a row to the next, of a print that is stretched; none: the spacing.
  std::optional<double> row_spacing{};
  double circle_diameter = 0.8;  ///< in spacings
  double marker_side = 0.75;     ///< in squares
  int marker_bits = 4;           ///< of the ArUco dictionary: 4, 5, 6 or 7 squared
};

/// Throws Error, naming the value, for a board that cannot be.
void require_valid(const CalibrationBoard& board);

/// Corners, or circles, of the whole board.
int place_count(const CalibrationBoard& board);

/// Where its corners (centres of circles) are as printed, row by row, mm, Z = 0.
BoardPlaces printed_places(const CalibrationBoard& board);

/// The board to print, dark on white, with a white margin of one spacing. Throws Error unless a
/// spacing is 8 to 1000 pixels, and for a board of two spacings.
Image<std::uint8_t> draw_board(const CalibrationBoard& board, int pixels_per_spacing);

/// What a ruler says of a print, mm: from the first to the last corner of a row and of a column.
struct MeasuredPrint {
  double along_row = 0;
  double along_column = 0;
};

/// Whether the print is as large as the board says and stretched along neither axis, as well as a
/// ruler can tell: nothing else can, since a calibration of any scale fits the frames as well. The
/// advice holds the spacing to give. Throws Error for lengths that are not above 0.
std::vector<Finding> findings_of_ruler(const CalibrationBoard& board,
                                       const MeasuredPrint& measured);

}  // namespace slipstream
