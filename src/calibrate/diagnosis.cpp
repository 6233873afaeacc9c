#include "calibrate/diagnosis.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/numbers.h"
#include "base/statistics.h"
#include "calibrate/board_view.h"

namespace slipstream {
namespace {

void add_gamma(std::vector<Finding>& findings, const std::vector<FringeSigns>& scans) {
  const auto rippled = std::ranges::count_if(scans, has_ripple);
  // A response affects all scans; a ripple in only a few has another cause.
  if (2 * rippled < std::ssize(scans) || rippled == 0) return;

  const double ripple = median_of(scans, &FringeSigns::ripple);
  const double pixels = median_of(
      scans, [](const FringeSigns& signs) { return signs.ripple * signs.period / two_pi; });
  findings.push_back(
      {.kind = FindingKind::phase_ripple,
       .what = fmt::format("the phase has a ripple that repeats {} times in each fringe",
                           scans.front().steps),
       .evidence = {{"ripple", ripple, "rad"}, {"ripple", pixels, "projector px"}},
       .causes = {{CauseKind::gamma,
                   "uncorrected gamma: the projector's or the camera's response is not linear"}},
       .remedies = {{"run `calibrate_gamma()` on the same scanner file, then repeat this"},
                    {"turn off the projector's gamma and picture modes"}}});
}

void add_blur(std::vector<Finding>& findings, const BoardViews& views,
              const std::vector<FringeSigns>& scans) {
  // Half as much modulation doubles the noise of the phase; sharp fringes keep over 0.9.
  constexpr double least_contrast = 0.6;

  // A camera out of focus blurs the fringes too, so the print is judged first.
  std::vector<EdgeSoftness> edges;
  for (const BoardView& view : views) {
    if (view.signs.edges.pixels > 0) edges.push_back(view.signs.edges);
  }
  if (!edges.empty()) {
    const double wide = median_of(edges, &EdgeSoftness::pixels);
    const double share = median_of(edges, &EdgeSoftness::spacings);
    if (is_soft({wide, share})) {
      findings.push_back(
          {.kind = FindingKind::blurred_print,
           .what = "the board's printed edges are blurred by over 1/8 square",
           .evidence = {{"softness", wide, "px", soft_pixels},
                        {"softness", share, "squares", soft_spacings}},
           .causes = {{CauseKind::blur, "the camera is out of focus, or the board moved"}},
           .remedies = {{"focus the camera on the board, stop down, hold the board still"}}});
      return;
    }
  }

  if (scans.empty()) return;
  const double contrast = median_of(scans, &FringeSigns::contrast);
  if (contrast >= least_contrast) return;

  findings.push_back(
      {.kind = FindingKind::faint_fringes,
       .what = fmt::format("the fine fringes keep less than {:g} of the coarse ones' modulation, "
                           "although the print is sharp",
                           least_contrast),
       .evidence = {{.name = "modulation, of the coarse fringes'",
                     .value = contrast,
                     .limit = least_contrast}},
       .causes = {{CauseKind::blur, "the projector is out of focus"}},
       .remedies = {{"focus the projector on the board, or use fewer periods"}}});
}

/// Returns k if the shift equals k of a fringe's N steps, else nullopt.
std::optional<int> slipped_steps(double shift, const FringeSigns& signs) {
  if (signs.steps == 0 || signs.period <= 0) return std::nullopt;

  constexpr double tolerance = 0.05;  // of a step: chance hits one in ten
  const double steps = shift / signs.period * signs.steps;
  const double whole = std::round(steps);
  if (std::abs(steps - whole) > tolerance) return std::nullopt;

  // A whole fringe is another fringe order, not a slip.
  const int slipped = (static_cast<int>(whole) % signs.steps + signs.steps) % signs.steps;
  return slipped == 0 ? std::nullopt : std::optional(slipped);
}

/// Which poses would determine the focal lengths: those whose tilt no pose has.
std::string wanted_tilts(const std::vector<Eigen::Isometry3d>& poses) {
  const double least = std::sin(12 * degree);
  constexpr std::array edges{"left", "right", "upper", "lower"};

  // An edge is nearer to the camera if the opposite one is farther away.
  std::array<bool, 4> tilted{};
  for (const Eigen::Isometry3d& pose : poses) {
    const Eigen::Vector2d rise = pose.linear().row(2).head<2>();
    tilted[0] |= rise.x() > least;
    tilted[1] |= rise.x() < -least;
    tilted[2] |= rise.y() > least;
    tilted[3] |= rise.y() < -least;
  }

  std::vector<std::string> missing;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    if (!tilted[i]) missing.emplace_back(edges[i]);
  }
  if (missing.empty()) return "add poses tilted by 20 to 40 degrees, each in another direction";
  return fmt::format(
      "add poses with these edges of the board tilted towards the camera by 20 to 40 degrees, one "
      "each: {}",
      fmt::join(missing, ", "));
}

void add_lens(std::vector<Finding>& findings, const GeometryCalibration& calibration,
              const char* device, const Lens& lens, const LensDeviation& deviation) {
  constexpr double most_doubt = 0.002;  // relative error of lengths at the ends of the depth range
  constexpr double enough_tilt = 30 * degree;

  const double doubt = deviation.focal.maxCoeff() / lens.intrinsic(0, 0);
  if (doubt <= most_doubt) return;

  Cause cause{CauseKind::inaccurate_corners, "inaccurate corners: blur, darkness or noise"};
  if (calibration.largest_tilt < enough_tilt) {
    cause = {CauseKind::few_tilts, "too few tilts of the board"};
  } else if (calibration.poses.size() < 8) {
    cause = {CauseKind::few_poses, "too few poses"};
  }

  findings.push_back({.kind = FindingKind::uncertain_focal_length,
                      .what = fmt::format("the {}'s focal length is uncertain by over {:g} %",
                                          device, 100 * most_doubt),
                      .evidence = {{"standard deviation", 100 * doubt, "%", 100 * most_doubt},
                                   {"largest tilt", calibration.largest_tilt / degree, "degrees"}},
                      .causes = {std::move(cause)},
                      .remedies = {{wanted_tilts(calibration.state.poses)}}});
}

/// At least one board needs this tilt: below it the focal lengths are uncertain.
constexpr double least_tilt = 15 * degree;

void add_poses(std::vector<Finding>& findings, const GeometryCalibration& calibration,
               bool nearly_parallel) {
  constexpr std::size_t few_poses = 5;
  constexpr double least_lit = 0.9;  // of the corners
  // The devices share about two thirds of each picture, and boards cannot reach all that area.
  constexpr double least_covered = 0.4;

  for (const CalibratedPose& pose : calibration.poses) {
    if (pose.lit >= least_lit * pose.corners) continue;
    findings.push_back(
        {.kind = FindingKind::unlit_corners,
         .what = fmt::format("over {:g} % of the corners have no projector coordinate",
                             100 * (1 - least_lit)),
         .evidence = {{.name = "corners without",
                       .value = static_cast<double>(pose.corners - pose.lit),
                       .limit = (1 - least_lit) * pose.corners},
                      {"corners", static_cast<double>(pose.corners)}},
         .causes = {{CauseKind::unclear,
                     "parts of the board too dark, overexposed, or outside the projector's light"}},
         .remedies = {{"light the whole board, change the exposure or lower `minimum_modulation`"}},
         .subject = pose.name});
  }

  const auto count = calibration.poses.size();
  if (count < few_poses) {
    findings.push_back(
        {.kind = FindingKind::few_poses,
         .what = fmt::format("only {} poses, fewer than {}", count, few_poses),
         .evidence = {{.name = "poses",
                       .value = static_cast<double>(count),
                       .limit = static_cast<double>(few_poses)}},
         .causes = {{CauseKind::few_poses, "too few poses, or too many unusable ones"}},
         .remedies = {{"take ten or more"}}});
  }

  if (nearly_parallel) {
    findings.push_back(
        {.kind = FindingKind::parallel_boards,
         .what = "all boards are nearly parallel, within 15 degrees: focal lengths are uncertain",
         .evidence = {{"largest tilt", calibration.largest_tilt / degree, "degrees",
                       least_tilt / degree}},
         .causes = {{CauseKind::few_tilts, "too few tilts of the board"}},
         .remedies = {{wanted_tilts(calibration.state.poses)}}});
  }

  for (const auto& [device, covered] : {std::pair("camera", calibration.covered_camera),
                                        std::pair("projector", calibration.covered_projector)}) {
    if (covered >= least_covered) continue;
    findings.push_back(
        {.kind = FindingKind::uncovered_picture,
         .what = fmt::format("the {}'s distortion is not known outside the boards, which cover "
                             "less than {:g} % of its picture",
                             device, 100 * least_covered),
         .evidence = {{"covered share", 100 * covered, "%", 100 * least_covered}},
         .causes = {{CauseKind::board_coverage,
                     "boards held only in the middle of the picture, or too far away"}},
         .remedies = {{"add poses near the edges and corners"}}});
  }
}

void add_print(std::vector<Finding>& findings, const PrintShape& print) {
  constexpr double deviations = 6;         // the places' errors are correlated
  constexpr double least_bend = 0.001;     // of the board's size: allowed for a flat board
  constexpr double least_stretch = 0.004;  // four times a good printer's

  const double most_bend = std::max(least_bend * print.size, deviations * print.bend_deviation);
  if (print.bend > most_bend) {
    findings.push_back(
        {.kind = FindingKind::bent_board,
         .what = fmt::format("the board is bent by over {:g} % of its size", 100 * least_bend),
         .evidence = {{"bend", print.bend, "mm", most_bend},
                      {"size of the board", print.size, "mm"}},
         .causes = {{CauseKind::bent_board, "a bent board"}},
         .remedies = {{"glue the print to something flat, such as glass, or use `print estimated`",
                       {{"print", "estimated"}}}}});
  }

  const double most_stretch = std::max(least_stretch, deviations * print.stretch_deviation);
  if (std::abs(print.stretch) > most_stretch) {
    findings.push_back(
        {.kind = FindingKind::stretched_board,
         .what = fmt::format("the spacings of the board's rows and columns differ by over {:g} %",
                             100 * least_stretch),
         .evidence = {{"rows to columns", 100 * print.stretch, "%", 100 * most_stretch}},
         .causes = {{CauseKind::board_print, "a print stretched along one axis"}},
         .remedies = {{"measure the print and pass both lengths with `measured`"}}});
  }
}

void add_projector_size(std::vector<Finding>& findings, const GeometryCalibration& calibration) {
  constexpr double least = 0.02, deviations = 6;

  const auto aspect = [](const Lens& lens) { return lens.intrinsic(1, 1) / lens.intrinsic(0, 0); };
  const Scanner& scanner = calibration.state.scanner;
  const double ratio = aspect(scanner.projector) / aspect(scanner.camera);
  const double deviation =
      calibration.deviation.projector.focal.norm() / scanner.projector.intrinsic(0, 0);

  // Some projectors' pixels are twice or half as high as wide.
  const auto off = [&](double pixels) { return std::abs(ratio / pixels - 1); };
  if (std::min({off(1), off(2), off(0.5)}) < std::max(least, deviations * deviation)) return;

  findings.push_back(
      {.kind = FindingKind::oblong_projector_pixels,
       .what = fmt::format("the projector's pixels are over {:g} % off square", 100 * least),
       .evidence = {{"height to width", 1 / ratio}},
       .causes = {{CauseKind::projector_size,
                   "another projector size than the patterns were made for"}},
       .remedies = {{"set `projector` to the size of the patterns"}}});
}

/// Whether all corners are off by about the same amount, as after a movement.
bool is_shift(const ProjectorOffset& offset) {
  constexpr double most_spread = 0.3;
  return offset.spread < most_spread * offset.mean.norm();
}

void add_worst_pose(std::vector<Finding>& findings, const GeometryCalibration& calibration) {
  // A shift: twice the RMS of the others; chance gives 1 to 2.5. Otherwise the lens model may not
  // extrapolate to the pose, which gives up to 8 on real boards.
  constexpr double largest_of_shift = 4, largest = 12;

  const auto& poses = calibration.poses;
  const auto worst = std::ranges::max_element(poses, {}, &CalibratedPose::misfit);
  if (worst->misfit <= (is_shift(worst->offset) ? largest_of_shift : largest)) return;

  findings.push_back(finding_of_pose(calibration.views[worst - poses.begin()], worst->offset));
  findings.back().evidence.push_back({"its RMS", worst->rms.stereo, "px"});
  findings.back().evidence.push_back({"RMS of all", calibration.rms.stereo, "px"});
}

/// Factor by which a second rig reduces the squared error: without movement 1.01 to 1.05.
constexpr double least_gain = 1.3;

/// Whether several poses are shifted equally badly, and two rigs explain them better than one.
bool has_moved(const GeometryCalibration& calibration) {
  constexpr double least_misfit = 4, dominance = 3;
  if (!calibration.moved || calibration.moved->gain < least_gain) return false;

  std::vector<double> misfits;
  for (const CalibratedPose& pose : calibration.poses) {
    if (is_shift(pose.offset) && pose.misfit > least_misfit) misfits.push_back(pose.misfit);
  }
  std::sort(misfits.rbegin(), misfits.rend());

  return misfits.size() >= 2 && misfits[0] < dominance * misfits[1];
}

void add_large_rms(std::vector<Finding>& findings, const ReprojectionRms& rms) {
  constexpr double largest_camera = 0.5, largest_projector = 0.7;  // pixels

  if (rms.camera > largest_camera) {
    findings.push_back({.kind = FindingKind::large_camera_rms,
                        .what = fmt::format("the camera's RMS is above {:g} px", largest_camera),
                        .evidence = {{"camera RMS", rms.camera, "px", largest_camera}},
                        .causes = {{CauseKind::inaccurate_corners,
                                    "inaccurate corners: the board moved, darkness or noise"}},
                        .remedies = {{"hold the board still, lengthen the exposure"}}});
  }

  if (rms.projector > largest_projector) {
    findings.push_back(
        {.kind = FindingKind::large_projector_rms,
         .what = fmt::format("the projector's RMS is above {:g} px", largest_projector),
         .evidence = {{"projector RMS", rms.projector, "px", largest_projector}},
         .causes = {{CauseKind::inaccurate_corners, "faint, dark or overexposed fringes"}},
         .remedies = {{"brighten the projector or change the exposure"}}});
  }
}

}  // namespace

std::vector<Finding> findings_of_frames(const BoardViews& views) {
  std::vector<Finding> findings;

  constexpr double most_saturated = 0.25;  // half of the bright squares
  const double saturated = median_of(views, [](const BoardView& view) {
    return std::max(view.signs.x.saturated, view.signs.y.saturated);
  });

  if (saturated > most_saturated) {
    findings.push_back(
        {.kind = FindingKind::saturated_board,
         .what =
             fmt::format("over {:g} % of the board is saturated and ignored", 100 * most_saturated),
         .evidence = {{"saturated share", 100 * saturated, "%", 100 * most_saturated}},
         .causes = {{CauseKind::overexposure, "overexposed frames"}},
         .remedies = {{"shorten the exposure, stop down or dim the projector"}}});
  }

  std::vector<FringeSigns> scans;  // those measured
  for (const BoardView& view : views) {
    for (const FringeSigns& signs : {view.signs.x, view.signs.y}) {
      if (signs.period > 0) scans.push_back(signs);
    }
  }

  add_blur(findings, views, scans);
  add_gamma(findings, scans);
  return findings;
}

Finding finding_of_pose(const BoardView& view, const ProjectorOffset& offset) {
  constexpr double most_beside = 0.3;
  const Eigen::Vector2d shift = offset.mean;
  const bool along_x = std::abs(shift.y()) < most_beside * std::abs(shift.x());
  const bool along_y = std::abs(shift.x()) < most_beside * std::abs(shift.y());

  Finding finding{
      .kind = FindingKind::odd_pose,
      .what = "the corners do not fit the other poses",
      .evidence = {{"shift along x", shift.x(), "projector px"},
                   {"shift along y", shift.y(), "projector px"},
                   {"spread about it", offset.spread, "projector px"}},
      .causes = {{CauseKind::moved_board,
                  "one bad pose: the board moved or bent, or the frames are another camera's"}},
      .remedies = {{fmt::format("capture it again, or calibrate with `excluded {}`", view.name),
                    {{"excluded", view.name}}}},
      .subject = view.name};

  if (!is_shift(offset)) return finding;

  const auto slip = along_x   ? slipped_steps(shift.x(), view.signs.x)
                    : along_y ? slipped_steps(shift.y(), view.signs.y)
                              : std::nullopt;
  const char* const axis = along_x ? "x" : "y";

  if (slip) {
    finding.causes = {
        {CauseKind::frame_order,
         fmt::format("a slip: the frames along {} are in the wrong order, {} steps late", axis,
                     *slip)}};
  } else if (along_x || along_y) {
    finding.causes.front().text = fmt::format(
        "one bad pose: the board moved between the scans along x and y, mostly along {}", axis);
  } else {
    finding.causes.front().text = "one bad pose: camera, projector or board moved during it";
  }

  return finding;
}

Finding finding_of_moved_rig(const std::string& last, const std::string& first) {
  return {
      .kind = FindingKind::two_rigs,
      .what = fmt::format("the poses up to {} and from {} on fit two rigs, not one", last, first),
      .causes = {{CauseKind::rig_moved,
                  "the rig was moved: camera and projector shifted relative to each other"}},
      .remedies = {{"clamp both to one base; leave out the poses before or after the move with "
                    "`excluded`"}}};
}

std::vector<Finding> findings_about(const GeometryCalibration& calibration) {
  std::vector<Finding> findings = findings_of_frames(calibration.views);

  if (has_moved(calibration)) {
    const auto& [first, gain] = *calibration.moved;
    findings.push_back(
        finding_of_moved_rig(calibration.poses[first - 1].name, calibration.poses[first].name));
    findings.back().evidence = {{.name = "squared error with one rig, of that with two",
                                 .value = gain,
                                 .limit = least_gain}};
  } else {
    add_worst_pose(findings, calibration);
  }

  const bool nearly_parallel = calibration.largest_tilt < least_tilt;

  // Problems found so far also bend the estimated board and make other results uncertain.
  if (findings.empty() && !nearly_parallel) {
    add_print(findings, calibration.print);
    add_projector_size(findings, calibration);
    if (findings.empty()) {
      const Scanner& scanner = calibration.state.scanner;
      add_lens(findings, calibration, "camera", scanner.camera, calibration.deviation.camera);
      add_lens(findings, calibration, "projector", scanner.projector,
               calibration.deviation.projector);
      add_large_rms(findings, calibration.rms);
    }
  }

  add_poses(findings, calibration, nearly_parallel);
  return findings;
}

}  // namespace slipstream
