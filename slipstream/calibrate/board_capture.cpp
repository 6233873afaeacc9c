#include "slipstream/calibrate/board_capture.h"

#include <utility>
#include <variant>

#include <fmt/format.h>

#include "slipstream/calibrate/projector_corners.h"
#include "slipstream/error/error.h"
#include "slipstream/strategy/decoder.h"

namespace slipstream {
namespace {

/// Throws Error where frames of that strategy alone do not give the projector coordinate.
void require_coordinate(const Strategy& strategy) {
  if (!has_coordinate(strategy)) {
    throw Error(
        fmt::format("{} with these settings gives no projector coordinate; use "
                    "dual-frequency, or pmp with frequency 1",
                    name_of(strategy)));
  }
  const auto* pcmp = std::get_if<PhaseChannelMultiplexing>(&strategy);
  if (pcmp != nullptr && pcmp->steps == 3) {
    throw Error("pcmp of 3 steps needs the ambient light; scan boards with dual-frequency");
  }
}

DecodedScan decoded(const AxisScan& scan, int length) {
  const Decoder decode(scan.strategy, length, Backend::equation, {}, {.light = scan.light});
  return decode(scan.frames);
}

void require_valid(const BoardCaptureSettings& settings) {
  if (!(settings.minimum_modulation >= 0 && settings.minimum_modulation <= 255)) {
    throw Error(fmt::format("least modulation {} is out of range; 0 to 255 grey levels",
                            settings.minimum_modulation));
  }
  if (!(settings.neighbourhood > 0 && settings.neighbourhood <= 10)) {
    throw Error(fmt::format("neighbourhood {} is out of range; above 0, at most 10",
                            settings.neighbourhood));
  }
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
  require_valid(settings);
  require_coordinate(along_x.strategy);
  require_coordinate(along_y.strategy);
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
