#include "slipstream/calibrate/board_capture.h"

#include <utility>

#include <fmt/format.h>

#include "slipstream/calibrate/projector_corners.h"
#include "slipstream/error/error.h"
#include "slipstream/strategy/decoder.h"

namespace slipstream {
namespace {

DecodedScan decoded(const AxisScan& scan, int length) {
  if (!has_coordinate(scan.strategy)) {
    throw Error(
        fmt::format("{} with these settings gives no projector coordinate; use "
                    "dual-frequency, or pmp with frequency 1",
                    name_of(scan.strategy)));
  }
  return Decoder(scan.strategy, length, Backend::equation)(scan.frames);
}

std::string why_none(const CalibrationBoard& board, const FringeFreePictures& pictures) {
  if (board.kind == BoardKind::chessboard) {
    const std::optional<Size> seen = chessboard_size(pictures);
    if (seen && seen != Size{board.columns, board.rows}) {
      return fmt::format(
          "no chessboard of {}x{} corners is seen whole, but one of at least {}x{}; check "
          "--corners",
          board.columns, board.rows, seen->width, seen->height);
    }
  }
  return fmt::format("no {} of {}x{} corners is seen{}", name_of(board.kind), board.columns,
                     board.rows, board.kind == BoardKind::charuco ? "" : " whole");
}

}  // namespace

BoardCapture board_capture(const std::string& name, const CalibrationBoard& board,
                           const AxisScan& along_x, const AxisScan& along_y, Size projector,
                           const BoardCaptureSettings& settings) {
  constexpr int fewest_lit = 8;
  const FringeFreePictures pictures = fringe_free_pictures(along_x.frames, along_y.frames);
  std::optional<BoardCorners> found = find_board(board, pictures);
  if (!found) {
    return {std::nullopt, why_none(board, pictures)};
  }
  const ProjectorMap map =
      projector_map(along_x.frames, decoded(along_x, projector.width), along_y.frames,
                    decoded(along_y, projector.height), projector, settings.minimum_modulation);
  BoardView view{name, std::move(found->places), std::move(found->pixels), {}, {}};
  for (const ProjectorCorner& corner :
       projector_corners(map, view.camera, settings.neighbourhood)) {
    view.projector.push_back(corner.pixel);
    view.slopes.push_back(corner.slope);
  }
  const int lit = lit_corners(view);
  if (lit < fewest_lit) {
    return {std::nullopt,
            fmt::format("the projector lights {} of {} corners well enough; at least {} are needed",
                        lit, view.places.size(), fewest_lit)};
  }
  std::string told = fmt::format("{} corners ({}), {} with a projector coordinate",
                                 view.places.size(), found->detector, lit);
  return {std::move(view), std::move(told)};
}

}  // namespace slipstream
