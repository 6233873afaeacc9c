#include "slipstream/calibrate/board_capture.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/calibrate/board_corners.h"
#include "slipstream/check/scan_check.h"
#include "slipstream/codes/registry.h"
#include "slipstream/decode/decoder.h"
#include "slipstream/response/correction.h"

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

/// Adds what the frames of a pose along an axis say of how they were taken, and puts those in order
/// that have slipped.
void check_and_repair(Scan& scan, const std::string& pose, const BoardCaptureSettings& settings,
                      std::vector<Finding>& findings) {
  const int wanted = frame_count(scan.sequence.strategy);
  if (scan.frames.count() != wanted) {
    throw Error(fmt::format("{} frames, but a scan takes {}", scan.frames.count(), wanted));
  }
  // Darker pixels would be judged by their noise.
  const double least = std::max(10.0, 2 * settings.minimum_modulation);
  ScanFindings found =
      check_frames(scan.frames, scan.sequence, std::nullopt,
                   {.minimum_modulation = least, .photometry = {.response = settings.response}});
  // These are told once, of all poses, by what they do to the boards and their corners.
  for (const std::string_view known :
       {gamma_is_to_blame, clipping_is_to_blame, darkness_is_to_blame}) {
    found.findings = without_cause(std::move(found.findings), known);
  }
  for (Finding& finding : found.findings) {
    finding.what = fmt::format("{} along {}: {}", pose, name_of(scan.sequence.axis), finding.what);
    findings.push_back(std::move(finding));
  }
  if (!found.order.empty()) scan.frames = reordered(std::move(scan.frames), found.order);
}

/// What a scan says of a board.
struct ReadScan {
  BasicMaps<double> maps;
  FringeSigns signs;
};

ReadScan read(const Scan& scan, const BoardCorners& board, const BoardCaptureSettings& settings) {
  const Strategy& strategy = scan.sequence.strategy;
  PhaseCorrections corrections;
  if (settings.response) {
    corrections = phase_corrections(settings.response->response, step_counts(strategy));
  }
  const Decoder decode(strategy.layout(), length_along(scan.sequence.axis, scan.sequence.projector),
                       PhaseMethod::equation, corrections, {.light = scan.sequence.light});
  return {decode(scan.frames),
          fringe_signs(scan, board.pixels, settings.minimum_modulation, corrections)};
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

BoardCapture board_capture(const std::string& name, const CalibrationBoard& board, Scan along_x,
                           Scan along_y, const BoardCaptureSettings& settings) {
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
  std::vector<Finding> findings;
  for (Scan* const scan : {&along_x, &along_y}) check_and_repair(*scan, name, settings, findings);
  const auto wrong = std::find_if(findings.begin(), findings.end(), [](const Finding& finding) {
    return finding.gravity == Gravity::wrong;
  });
  if (wrong != findings.end()) {
    std::string told = fmt::format("likely {}", wrong->likely);
    return {std::nullopt, std::move(told), std::move(findings)};
  }
  const ReadScan x = read(along_x, *found, settings), y = read(along_y, *found, settings);
  const CaptureSigns signs{x.signs, y.signs,
                           edge_softness(pictures.mean, board, found->places, found->pixels)};
  const ProjectorMap map = projector_map(along_x.frames, x.maps, along_y.frames, y.maps, projector,
                                         settings.minimum_modulation);
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
                    lit, view.places.size(), fewest_lit, why_unlit(signs)),
        std::move(findings)};
  }
  std::string told = fmt::format("{} corners ({}), {} with a projector coordinate",
                                 view.places.size(), found->detector, lit);
  return {std::move(view), std::move(told), std::move(findings)};
}

}  // namespace slipstream
