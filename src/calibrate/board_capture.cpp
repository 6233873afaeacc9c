#include "slipstream/board_capture.h"

#include <algorithm>
#include <iterator>
#include <string_view>

#include "base/throw_if-inl.h"
#include "calibrate/board_corners.h"
#include "calibrate/board_view.h"
#include "calibrate/projector_corners.h"
#include "decode/decoder.h"
#include "decode/phase_decoder.h"
#include "response/correction.h"
#include "slipstream/check.h"
#include "slipstream/geometry_calibration.h"
#include "slipstream/strategy.h"

namespace slipstream {
namespace {

/// Throws Error if the strategy's frames alone do not give the projector coordinate.
void require_coordinate(const Strategy& strategy) {
  throw_if(!has_coordinate(strategy),
           "{} with these settings gives no projector coordinate; use one period, or a "
           "strategy that unwraps",
           strategy.name());
  throw_if(needs_ambient_light(strategy.layout()),
           "{} of {} steps requires the ambient light; scan boards with {}", strategy.name(),
           frame_count(strategy), default_strategy().name());
}

/// Adds the diagnostics of a pose's frames along an axis, and puts slipped frames in order.
void check_and_repair(Scan& scan, const std::string& pose, const BoardCaptureSettings& settings,
                      std::vector<Finding>& findings) {
  const int wanted = frame_count(scan.sequence.strategy);
  throw_if(scan.frames.count() != wanted, "{} frames; a scan has {}", scan.frames.count(), wanted);

  // Darker pixels are too noisy for the check.
  const double least = std::max(10.0, 2 * settings.minimum_modulation);
  ScanFindings found =
      check_frames(scan.frames, scan.sequence, std::nullopt,
                   {.minimum_modulation = least, .photometry = {.response = settings.response}});

  // These are reported once for all poses, by their effect on the corners.
  for (const CauseKind known :
       {CauseKind::gamma, CauseKind::overexposure, CauseKind::underexposure}) {
    found.findings = without_cause(std::move(found.findings), known);
  }

  for (Finding& finding : found.findings) {
    finding.subject = fmt::format("{} along {}", pose, name_of(scan.sequence.axis));
    findings.push_back(std::move(finding));
  }

  if (!found.order.empty()) scan.frames = reordered(std::move(scan.frames), found.order);
}

/// A decoded scan of a board.
struct ReadScan {
  BasicMaps<double> maps;
  FringeSigns signs;
};

ReadScan read(const Scan& scan, const BoardCorners& board, const BoardCaptureSettings& settings) {
  const Strategy& strategy = scan.sequence.strategy;

  PhaseCorrections corrections;
  if (settings.response) {
    corrections = phase_corrections(settings.response->response, strategy.layout());
  }

  const Decoder decode(strategy.layout(), length_along(scan.sequence.axis, scan.sequence.projector),
                       PhaseMethod::equation, corrections, {.light = scan.sequence.light});
  return {decode(scan.frames),
          fringe_signs(scan, board.pixels, settings.minimum_modulation, corrections)};
}

void require_valid(const BoardCaptureSettings& settings) {
  const auto [least, neighbourhood, response, projector] = settings;
  require_in_range(least >= 0 && least <= 255, "least modulation", least, "0 to 255 grey levels");
  require_in_range(neighbourhood > 0 && neighbourhood <= 10, "neighbourhood", neighbourhood,
                   "above 0, at most 10");
}

std::string why_none(const CalibrationBoard& board, const FringeFreePictures& pictures) {
  if (board.kind == BoardKind::chessboard) {
    const std::optional<Size> seen = chessboard_size(pictures);
    if (seen && seen != Size{board.columns, board.rows}) {
      return fmt::format(
          "no chessboard of {}x{} corners is fully visible, but one of at least {}x{} is; check "
          "`corners`",
          board.columns, board.rows, seen->width, seen->height);
    }
  }

  // The other arrangement of circles.
  if (has_circles(board)) {
    CalibrationBoard other = board;
    other.kind =
        board.kind == BoardKind::circles ? BoardKind::symmetric_circles : BoardKind::circles;
    other.circle_diameter.reset();
    if (find_board(other, pictures)) {
      return fmt::format("the circles of {}x{} are {}; use `board {}`", board.columns, board.rows,
                         other.kind == BoardKind::circles ? "shifted in every second row"
                                                          : "in rows and columns, none shifted",
                         name_of(other.kind));
    }
  }

  return fmt::format(
      "no {} of {}x{} corners is {}visible; likely a wrong `board`, `corners`{}, or a picture that "
      "is dark, overexposed or out of focus",
      name_of(board.kind), board.columns, board.rows,
      board.kind == BoardKind::charuco ? "" : "fully ",
      board.kind == BoardKind::charuco ? " or `dictionary`" : "");
}

void require_same(Size& known, Size size, const std::string& pose, const char* what) {
  if (known == Size{}) known = size;
  throw_if(size != known,
           "{}: {} {}, but {} in earlier poses; likely frames of two cameras are mixed: use "
           "poses of one camera and projector",
           pose, what, text_of(size), text_of(known));
}

Scan scan_of(const BoardScans& pose, Axis axis, Size projector, PoseCaptures& captures) {
  Scan scan = pose.along(axis);
  if (scan.sequence.projector == Size{}) scan.sequence.projector = projector;

  captures.warnings.insert(captures.warnings.end(), scan.warnings.begin(), scan.warnings.end());
  throw_if(scan.sequence.projector == Size{}, "{}: no projector size; set it with `projector`",
           pose.name);

  require_same(captures.camera, scan.frames.size(), pose.name, "frames of");
  require_same(captures.projector, scan.sequence.projector, pose.name, "patterns for");
  return scan;
}

/// Finds the board in one more pose and adds the result; returns its description.
std::string add_pose(PoseCaptures& captures, const BoardScans& scans, const CalibrationBoard& board,
                     const BoardCaptureSettings& settings) {
  Scan x = scan_of(scans, Axis::x, settings.projector, captures);
  Scan y = scan_of(scans, Axis::y, settings.projector, captures);

  try {
    BoardCapture found = board_capture(scans.name, board, std::move(x), std::move(y), settings);
    captures.findings.insert(captures.findings.end(), found.findings.begin(), found.findings.end());

    if (found.view) {
      captures.views.push_back(std::move(*found.view));
      return found.message;
    }

    captures.unused.push_back({scans.name, found.message});
    return fmt::format("rejected: {}", found.message);
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", scans.name, error.what()));
  }
}

/// Reports light that changed within scans once: it is one camera's, and often in all of them.
void join_changing_light(std::vector<Finding>& findings) {
  const auto is_light = [](const Finding& finding) {
    return finding.kind == FindingKind::changing_light;
  };

  const auto count = std::ranges::count_if(findings, is_light);
  const auto first = std::ranges::find_if(findings, is_light);
  if (count < 2) return;

  first->subject += fmt::format(" and {} more scans", count - 1);
  first->remark = "then capture the poses again";
  findings.erase(std::remove_if(std::next(first), findings.end(), is_light), findings.end());
}

}  // namespace

BoardCapture board_capture(const std::string& name, const CalibrationBoard& board, Scan along_x,
                           Scan along_y, const BoardCaptureSettings& settings) {
  constexpr int fewest_lit = 8;

  // 1. The settings, and both scans together.
  require_valid(settings);
  const Size projector = along_x.sequence.projector;
  require_coordinate(along_x.sequence.strategy);
  require_coordinate(along_y.sequence.strategy);
  throw_if(projector == Size{} || along_y.sequence.projector != projector,
           "the scans are for projectors of {} and {}; both must have one known size",
           text_of(projector), text_of(along_y.sequence.projector));

  // 2. The corners in the camera's picture.
  const FringeFreePictures pictures = fringe_free_pictures(along_x.frames, along_y.frames);
  std::optional<BoardCorners> found = find_board(board, pictures);
  if (!found) return {std::nullopt, why_none(board, pictures)};

  // 3. The frames: puts slipped ones in order, and refuses wrong ones.
  std::vector<Finding> findings;
  for (Scan* const scan : {&along_x, &along_y}) check_and_repair(*scan, name, settings, findings);

  const auto wrong = std::ranges::find(findings, Severity::wrong, &Finding::severity);
  if (wrong != findings.end()) {
    std::string message = fmt::format("likely {}", causes_of(*wrong));
    return {std::nullopt, std::move(message), std::move(findings)};
  }

  // 4. The projector coordinate of every pixel, and the quality of the frames.
  const ReadScan x = read(along_x, *found, settings), y = read(along_y, *found, settings);
  const CaptureSigns signs{x.signs, y.signs,
                           edge_softness(pictures.mean, board, found->places, found->pixels)};

  const ProjectorMap map = projector_map(along_x.frames, x.maps, along_y.frames, y.maps, projector,
                                         settings.minimum_modulation);

  // 5. The projector pixel of each corner.
  BoardView view{name, std::move(found->places), std::move(found->pixels), {}, {}, signs};
  for (const ProjectorCorner& corner :
       projector_corners(map, view.camera, settings.neighbourhood)) {
    view.projector.push_back(corner.pixel);
    view.slopes.push_back(corner.slope);
  }

  const int lit = lit_corners(view);
  if (lit < fewest_lit) {
    constexpr double much = 0.3;  // of the board's pixels
    return {std::nullopt,
            fmt::format("the projector lights {} of {} corners (limit {}); likely {}", lit,
                        view.places.size(), fewest_lit,
                        std::max(signs.x.saturated, signs.y.saturated) > much
                            ? "overexposed: shorten the exposure or dim the projector"
                            : "too dark, or outside the projector's light: light the whole board"),
            std::move(findings)};
  }

  const std::size_t corners = view.places.size();
  std::string message =
      static_cast<std::size_t>(lit) == corners
          ? fmt::format("found all {} corners, all lit by the projector", corners)
          : fmt::format("found {} corners, {} of them lit by the projector", corners, lit);
  return {std::move(view), std::move(message), std::move(findings)};
}

void require_enough_poses(const PoseCaptures& captures, const std::string& folder) {
  if (captures.views.size() >= fewest_poses) return;

  const std::string first_reason =
      captures.unused.empty()
          ? ""
          : fmt::format(" ({}: {})", captures.unused[0].name, captures.unused[0].why);

  throw Error(fmt::format("{}: {} of {} poses are usable{}; at least {} are required", folder,
                          captures.views.size(), captures.views.size() + captures.unused.size(),
                          first_reason, fewest_poses));
}

PoseCaptures capture_poses(const std::string& folder, const std::vector<BoardScans>& poses,
                           const std::vector<std::string>& excluded, const CalibrationBoard& board,
                           const BoardCaptureSettings& settings,
                           const std::function<void(const std::string& words)>& report) {
  for (const std::string& name : excluded) {
    throw_if(std::ranges::count(poses, name, &BoardScans::name) == 0,
             "`excluded {}`: no such pose in {}", name, folder);
  }

  PoseCaptures captures;
  for (const BoardScans& pose : poses) {
    if (std::ranges::count(excluded, pose.name) == 0) {
      report(fmt::format("{}: {}", pose.name, add_pose(captures, pose, board, settings)));
    } else {
      captures.unused.push_back({pose.name, "excluded"});
      report("");
    }
  }

  join_changing_light(captures.findings);
  return captures;
}

}  // namespace slipstream
