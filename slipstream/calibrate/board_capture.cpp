#include "slipstream/calibrate/board_capture.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "slipstream/calibrate/diagnosis.h"
#include "slipstream/calibrate/projector_corners.h"
#include "slipstream/error/error.h"
#include "slipstream/strategy/registry.h"
#include "slipstream/unwrap/decoder.h"

namespace slipstream {
namespace {

/// Throws Error where frames of that strategy alone do not give the projector coordinate.
void require_coordinate(const Strategy& strategy) {
  if (!has_coordinate(strategy)) {
    throw Error(
        fmt::format("{} with these settings gives no projector coordinate; use one period, or a "
                    "strategy that unwraps",
                    strategy.name()));
  }
  if (needs_ambient_light(strategy.layout())) {
    throw Error(fmt::format("{} of {} steps needs the ambient light; scan boards with {}",
                            strategy.name(), frame_count(strategy), default_strategy().name()));
  }
}

BasicMaps<double> decoded(const Scan& scan, const PhaseCorrections& corrections) {
  const auto& [strategy, axis, light, projector, marker] = scan.sequence;
  const Decoder decode(strategy.layout(), length_along(axis, projector), PhaseMethod::equation,
                       corrections, {.light = light});
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
  return fmt::format(
      "no {} of {}x{} corners is seen{}; likely another board or count than said with "
      "--board, --corners{}, or a picture that is dark, overexposed or out of focus",
      name_of(board.kind), board.columns, board.rows,
      board.kind == BoardKind::charuco ? "" : " whole",
      board.kind == BoardKind::charuco ? " or --dictionary" : "");
}

/// Why corners that are seen have no projector pixel.
const char* why_unlit(const CaptureSigns& signs) {
  constexpr double much = 0.3;  // of the board's pixels
  if (std::max(signs.x.saturated, signs.y.saturated) > much) {
    return "overexposed: expose less or dim the projector";
  }
  return "too dark, or outside the projector's light";
}

}  // namespace

BoardCapture board_capture(const std::string& name, const CalibrationBoard& board,
                           const Scan& along_x, const Scan& along_y,
                           const BoardCaptureSettings& settings) {
  constexpr int fewest_lit = 8;
  require_valid(settings);
  const Size projector = along_x.sequence.projector;
  require_coordinate(along_x.sequence.strategy);
  require_coordinate(along_y.sequence.strategy);
  if (projector == Size{} || along_y.sequence.projector != projector) {
    throw Error(fmt::format("the scans say projectors of {} and {}; both are one, and known",
                            text_of(projector), text_of(along_y.sequence.projector)));
  }
  const FringeFreePictures pictures = fringe_free_pictures(along_x.frames, along_y.frames);
  std::optional<BoardCorners> found = find_board(board, pictures);
  if (!found) {
    return {std::nullopt, why_none(board, pictures)};
  }
  const PhaseCorrections& corrections = settings.corrections;
  const BasicMaps<double> x = decoded(along_x, corrections), y = decoded(along_y, corrections);
  const CaptureSigns signs{
      fringe_signs(along_x, found->pixels, settings.minimum_modulation, corrections),
      fringe_signs(along_y, found->pixels, settings.minimum_modulation, corrections),
      edge_softness(pictures.mean, board, found->places, found->pixels)};
  if (auto refusals = refusals_of_frames(name, signs); !refusals.empty()) {
    std::string told = fmt::format("likely {}", refusals.front().likely);
    return {std::nullopt, std::move(told), std::move(refusals)};
  }
  const ProjectorMap map =
      projector_map(along_x.frames, x, along_y.frames, y, projector, settings.minimum_modulation);
  BoardView view{name, std::move(found->places), std::move(found->pixels), {}, {}, signs};
  for (const ProjectorCorner& corner :
       projector_corners(map, view.camera, settings.neighbourhood)) {
    view.projector.push_back(corner.pixel);
    view.slopes.push_back(corner.slope);
  }
  const int lit = lit_corners(view);
  if (lit < fewest_lit) {
    return {
        std::nullopt,
        fmt::format("the projector lights {} of {} corners well enough; at least {} are needed; "
                    "likely {}",
                    lit, view.places.size(), fewest_lit, why_unlit(signs))};
  }
  std::string told = fmt::format("{} corners ({}), {} with a projector coordinate",
                                 view.places.size(), found->detector, lit);
  return {std::move(view), std::move(told), {}};
}

}  // namespace slipstream
