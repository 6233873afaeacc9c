#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "base/numbers.h"
#include "base/throw_if-inl.h"
#include "calibrate/bundle_adjustment.h"
#include "calibrate/diagnosis.h"
#include "calibrate/first_guess.h"
#include "calibrate/reprojection.h"

namespace slipstream {
namespace {

// Twice the errors of a good calibration on a new board.
constexpr double largest_epipolar = 0.5;       // projector pixels
constexpr double largest_scale_error = 0.002;  // of a length
constexpr double largest_flatness = 0.002;     // of the board's size

/// Distance of the projector pixel from the camera pixel's epipolar line, projector pixels.
double epipolar_distance(const Scanner& scanner, const Eigen::Vector2d& camera,
                         const Eigen::Vector2d& projector) {
  const Eigen::Vector3d line =
      scanner.translation.cross(scanner.rotation * ray_through(scanner.camera, camera));
  const double distance =
      line.dot(ray_through(scanner.projector, projector)) / line.head<2>().norm();
  return distance * scanner.projector.intrinsic(0, 0);
}

/// Measures a view, which is pose `v` of the state.
BoardMeasure measured(const BoardView& view, const BundleState& state, std::size_t v) {
  Squares epipolar;

  for (std::size_t i = 0; i < view.places.size(); ++i) {
    if (!view.projector[i].allFinite()) continue;
    epipolar.add(std::pow(epipolar_distance(state.scanner, view.camera[i], view.projector[i]), 2));
  }

  const auto quality = board_quality(view, state.scanner, state.places);
  throw_if(!quality, "{}: fewer than 4 corners are lit; light the whole board", view.name);
  return {epipolar.rms(), reprojection(view, state, v).rms(), *quality};
}

/// Root mean squares over poses.
BoardMeasure overall(const std::vector<VerifiedPose>& poses,
                     const BoardMeasure VerifiedPose::*which) {
  const auto rms = [&](const auto& figure_of) {
    Squares squares;
    for (const VerifiedPose& pose : poses) squares.add(std::pow(figure_of(pose.*which), 2));
    return squares.rms();
  };

  return {rms([](const BoardMeasure& of) { return of.epipolar; }),
          {rms([](const BoardMeasure& of) { return of.rms.camera; }),
           rms([](const BoardMeasure& of) { return of.rms.projector; }),
           rms([](const BoardMeasure& of) { return of.rms.stereo; })},
          {rms([](const BoardMeasure& of) { return of.quality.flatness; }),
           rms([](const BoardMeasure& of) { return of.quality.scale_error; }),
           rms([](const BoardMeasure& of) { return of.quality.distance_error; })}};
}

bool is_good(const BoardMeasure& measure, double size) {
  return measure.epipolar <= largest_epipolar &&
         std::abs(measure.quality.scale_error) <= largest_scale_error &&
         measure.quality.flatness <= largest_flatness * size;
}

/// Whether the correction only scales the baseline, as a wrong board spacing would.
bool only_scale(const Verification& verification, const Scanner& scanner) {
  constexpr double negligible_turn = 0.05 * degree;
  constexpr double most_across = 0.2;  // of the movement

  const Eigen::Vector3d moved = verification.corrected.translation - scanner.translation;
  const double across = moved.cross(scanner.translation.normalized()).norm();

  return verification.before.epipolar <= largest_epipolar &&
         verification.rotation < negligible_turn && across < most_across * moved.norm();
}

/// `size`: of the board, mm.
Finding finding_of(const Verification& verification, const Scanner& scanner,
                   const CalibrationBoard& board, double size) {
  const BoardMeasure& before = verification.before;

  Finding finding{
      .kind = FindingKind::inaccurate_scanner,
      .what = fmt::format("the scanner is no longer accurate: limits {:g} px, {:g} % and "
                          "{:g} of the board's size",
                          largest_epipolar, 100 * largest_scale_error, largest_flatness),
      .evidence = {
          {"epipolar distance", before.epipolar, "px", largest_epipolar},
          {"scale error", 100 * before.quality.scale_error, "%", 100 * largest_scale_error},
          {"flatness", before.quality.flatness, "mm", largest_flatness * size}}};

  if (verification.mended) {
    finding.causes = {
        {CauseKind::rig_moved,
         fmt::format("camera and projector moved relative to each other, by {:.2g} degrees and "
                     "{:.2g} mm",
                     verification.rotation / degree, verification.translation)}};
    finding.remedies = {{"write the corrected scanner file with `output`, and clamp both devices"}};
  } else if (only_scale(verification, scanner)) {
    const double scale = scanner.translation.norm() / verification.corrected.translation.norm();
    const std::string spacing = fmt::format("{:.4g}", scale * board.spacing);

    finding.causes = {{CauseKind::board_print,
                       "another spacing of the board than configured: only the scale is off"}};
    finding.remedies = {{fmt::format("measure the print; a `spacing` of {} mm fits", spacing),
                         {{"spacing", spacing}}}};
  } else {
    finding.causes = {{CauseKind::rig_moved, "more than movement: focus, zoom or a lens changed"},
                      {CauseKind::unclear, "wrong board settings"}};
    finding.remedies = {{"check the board's settings, then run `calibrate_geometry()` again"}};
  }

  return finding;
}

}  // namespace

Verification verify_scanner(BoardViews views, const CalibrationBoard& board,
                            const Scanner& scanner) {
  require_valid(board);
  require_valid(scanner);
  if (views.empty()) throw Error("no pose of the board; verifying requires at least one");
  const BoardPlaces printed = printed_places(board);
  views = checked_views(std::move(views), printed);

  // 1. The boards' poses before the scanner as it is.
  const BundleState state =
      bundle_adjusted(views, boards_before(scanner, views, printed), printed, all_held);

  // 2. The correction: the same with a free rig.
  BundleSettings settings = all_held;
  settings.hold_rig = false;
  const BundleState moved = bundle_adjusted(views, state, printed, settings);

  // 3. Each board by both.
  Verification result;
  result.findings = findings_of_frames(views);
  result.corrected = moved.scanner;
  for (std::size_t v = 0; v < views.size(); ++v) {
    result.poses.push_back(
        {views[v].name, measured(views[v], state, v), measured(views[v], moved, v)});
  }

  result.before = overall(result.poses, &VerifiedPose::before);
  result.after = overall(result.poses, &VerifiedPose::after);

  result.rotation =
      Eigen::AngleAxisd(scanner.rotation.transpose() * moved.scanner.rotation).angle();
  result.translation = (moved.scanner.translation - scanner.translation).norm();

  // 4. The verdict.
  const double size = (printed.back() - printed.front()).norm();
  result.holds = is_good(result.before, size);
  result.mended = !result.holds && is_good(result.after, size) && !only_scale(result, scanner);
  if (!result.holds) result.findings.push_back(finding_of(result, scanner, board, size));
  return result;
}

}  // namespace slipstream
