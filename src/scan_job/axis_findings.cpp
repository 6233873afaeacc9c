#include "scan_job/axis_findings.h"

#include <cstddef>
#include <utility>
#include <vector>

#include "scan_job/rig_motion.h"

namespace slipstream {
namespace {

std::vector<Evidence> evidence_of(const EpipolarCheck& check, double calibration_rms) {
  return {{"median distance from the epipolar lines", check.median_length, "projector pixels"},
          {"common to all points", check.common, "projector pixels",
           check.most_common(calibration_rms)},
          {"expected sigma", check.median_sigma, "projector pixels"},
          {"share of points too far from the rest", check.doubted_share(), "",
           EpipolarCheck::most_doubted}};
}

/// A guard and a scan that do not show the same.
Finding guard_that_does_not_fit(const EpipolarCheck& check, double calibration_rms) {
  return {.kind = FindingKind::axes_disagree,
          .what = "the guard does not fit the scan, so it cannot show whether the rig has moved",
          .evidence = evidence_of(check, calibration_rms),
          .causes = {{CauseKind::unclear, "the scene moved between the scan and its guard"},
                     {CauseKind::frame_order, "frames are in the wrong order"}},
          .remedies = {{"take scan and guard again"}}};
}

}  // namespace

std::optional<Finding> axes_that_disagree(const EpipolarCheck& check, double calibration_rms) {
  const bool contradicts = check.contradicts(calibration_rms);
  if (!contradicts && !check.is_off(calibration_rms)) return std::nullopt;

  Finding finding{.kind = FindingKind::axes_disagree,
                  .severity = contradicts ? Severity::wrong : Severity::doubtful,
                  .what = "the coordinates along x and y do not meet in one projector pixel"};
  finding.evidence = evidence_of(check, calibration_rms);

  if (check.doubted_share() > EpipolarCheck::most_doubted) {
    finding.causes = {{CauseKind::frame_order, "frames are in the wrong order"},
                      {CauseKind::pattern_settings, "other patterns along one of the axes"},
                      {CauseKind::rig_moved, "the camera or projector moved since calibration"}};
    finding.remedies = {{"compare the frames along y with the output of `patterns()`"}};
  } else if (contradicts) {
    finding.causes = {{CauseKind::rig_moved, "the camera or projector moved since calibration"},
                      {CauseKind::other_rig, "a scanner file of another rig"}};
    finding.remedies = {
        {"calibrate again with `calibrate_geometry()`; scans along x alone do not "
         "show this"}};
  } else {
    finding.causes = {
        {CauseKind::scanner_file, "the calibration's own error, as of a principal point"},
        {CauseKind::rig_moved, "a camera or projector that moved a little since"}};
    finding.remedies = {
        {"keep the points if an error of this size does not matter; else calibrate "
         "again with `calibrate_geometry()`, with more poses"}};
  }
  return finding;
}

std::optional<Finding> rig_that_moved(const Scanner& scanner, const GuardCheck& guard) {
  const EpipolarCheck& check = guard.epipolar;
  const double rms = scanner.calibration_rms;

  // 1. Few points, or points that lie anywhere, tell nothing; a common distance tells of the rig.
  // A scan of hardly a point is no fault of its guard.
  constexpr std::size_t fewest_points = 100;
  if (guard.measured < fewest_points) return std::nullopt;
  const bool is_scattered =
      check.doubted_share() > EpipolarCheck::most_doubted && 2 * check.own > check.common;
  if (check.points < fewest_points || is_scattered) return guard_that_does_not_fit(check, rms);
  if (!check.is_off(rms)) return std::nullopt;

  Finding finding{.kind = FindingKind::axes_disagree,
                  .severity = check.is_far_off(rms) ? Severity::wrong : Severity::doubtful,
                  .what =
                      "camera and projector do not stand as the scanner file says: the guard's "
                      "coordinates do not meet the scan's in one projector pixel"};
  finding.evidence = evidence_of(check, rms);
  for (const auto& [name, size] :
       {std::pair("constant part", check.constant), std::pair("linear part", check.linear),
        std::pair("quadratic part", check.quadratic)}) {
    finding.evidence.push_back({name, size, "projector pixels"});
  }

  // 2. The motions that explain the distance; else whatever changes a rig.
  finding.causes = rig_motions(scanner, guard);
  if (finding.causes.empty()) {
    finding.causes = {{CauseKind::rig_moved, "the camera or projector moved since calibration"},
                      {CauseKind::other_rig, "a scanner file of another rig"},
                      {CauseKind::unclear, "the scene moved between the scan and its guard"}};
  }
  finding.remedies = {
      {"put the rig back as it was, or calibrate again with `calibrate_geometry()`"}};
  return finding;
}

}  // namespace slipstream
