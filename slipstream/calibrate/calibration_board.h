#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include <Eigen/Core>

#include "slipstream/base/image.h"

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
std::vector<Eigen::Vector3d> printed_places(const CalibrationBoard& board);

/// The board to print, dark on white, with a white margin of one spacing. Throws Error unless a
/// spacing is 8 to 1000 pixels, and for a board of two spacings.
Image<std::uint8_t> draw_board(const CalibrationBoard& board, int pixels_per_spacing);

}  // namespace slipstream
