#include "slipstream/check.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <string_view>

#include <fmt/ranges.h>

#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "check/damaged_frames.h"
#include "check/explanations.h"
#include "check/frame_faults.h"
#include "check/judged_scan.h"
#include "check/mistake_search.h"
#include "check/scanner_faults.h"
#include "check/unrelated_pixels.h"
#include "check/wrapped_levels.h"

namespace slipstream {
namespace {

void append(std::vector<Finding>& findings, std::vector<Finding> more) {
  std::move(more.begin(), more.end(), std::back_inserter(findings));
}

/// The frames of a sinusoid differ by at least 1.5 modulations: with three steps, one at the crest.
constexpr double range_of_modulation = 1.5;

/// `name`: of a further camera; empty for the first.
void check_camera(Scan& camera, const CheckSettings& settings, const std::string& name,
                  CheckedScan& checked) {
  ScanFindings found = check_scan(camera, settings);
  if (name.empty()) checked.median_depth = found.median_depth;

  for (Finding& finding : found.findings) {
    finding.subject = name;
    checked.findings.push_back(std::move(finding));
  }

  // Repair: put slipped frames in the right order.
  if (found.order.empty()) return;
  camera.frames = reordered(std::move(camera.frames), found.order);
  camera.order = composed(camera.order, found.order);
  checked.repairs.push_back(fmt::format("{}{}frames put in the order {}", name,
                                        name.empty() ? "" : ": ", text_of(camera.order)));
}

/// Compares frames, sequence and scanner, and explains a misfit. `of_scanner`: the findings about a
/// scanner whose pictures may be cropped.
void judge(JudgedScan scan, std::vector<Finding> of_scanner, ScanFindings& result) {
  const Fit fit = fit_of(scan);

  // The axis of cropped and rectified pictures may lie anywhere, unless right frames do not fit.
  if (scan.scanner != nullptr && fit.frames_fit() && !fit.all()) {
    of_scanner = check_scanner(*scan.scanner);
  }
  scan.scanner_doubted = !of_scanner.empty();
  append(result.findings, std::move(of_scanner));

  ScanFindings explained = explain(scan, fit);

  // Frames that are not of the patterns they are taken for have no modulation either.
  if (any_wrong(explained.findings)) {
    std::erase_if(result.findings, [](const Finding& finding) {
      return finding.kind == FindingKind::low_modulation;
    });
  }

  append(result.findings, std::move(explained.findings));
  result.order = std::move(explained.order);
  result.median_depth = explained.median_depth;
}

}  // namespace

Finding wrong_origin(const Strategy& strategy, double phase_shift) {
  const auto run = bent_run(measuring_band(strategy.layout()));
  const double given = run ? run->shifts.origin : 0;
  const double fits = std::remainder(given - phase_shift, 2 * std::numbers::pi);

  return {.kind = FindingKind::cameras_disagree,
          .what = "the two cameras agree nowhere with the origin of the phase as given",
          .evidence = {{"origin that fits", fits, "rad"}},
          .causes = {{CauseKind::pattern_settings,
                      fmt::format("the first pattern does not begin with phase {:.4g} at the edge "
                                  "of the field; the points are of the origin that fits",
                                  given)}},
          .remedies = {change_settings("set", {{"origin", fmt::format("{:.3f}", fits)}})}};
}

double least_range(const CheckSettings& settings) {
  constexpr double dimmest = 10;
  return range_of_modulation * std::max(dimmest, settings.minimum_modulation);
}

ScanFindings check_frames(const FrameViews& frames, const Sequence& sequence,
                          const std::optional<Scanner>& scanner, const CheckSettings& settings) {
  // Frames computed from one picture cannot contradict each other, and are dark along every edge.
  if (sequence.strategy.is_spectral()) {
    return {.findings = scanner ? check_scanner(*scanner) : std::vector<Finding>(), .order = {}};
  }

  const int count = sequence.strategy.layout().frames;
  throw_if(frames.count() != count, "{} frames; the check takes {} merged ones", frames.count(),
           count);

  // 1. Sample lit pixels, and model the patterns.
  const double least = settings.minimum_modulation;
  const PhotometricCalibration& photometry = scanner ? scanner->photometry : settings.photometry;
  const FrameModel model(sequence, photometry);
  ScanSamples samples(frames.size(), frames.count());
  samples.take(frames, {.least_range = least_range(settings)});

  const bool too_dim_to_judge = samples.groups() == 0 && samples.saturated() == 0 &&
                                samples.largest_range() >= range_of_modulation * least;
  if (too_dim_to_judge) return {};

  // 2. Faulty light, damaged frames or an impossible scanner file make further tests pointless.
  ScanFindings result;
  result.findings = light_faults(model, samples, frames.quantised() ? frames.bits() : 0, least);
  if (any_wrong(result.findings)) return result;

  std::vector<Finding> damaged = damaged_frames(samples);
  const bool is_damaged = !damaged.empty();
  append(result.findings, std::move(damaged));
  if (is_damaged) return result;

  std::vector<Finding> of_scanner;
  if (scanner) of_scanner = check_scanner(*scanner, false);
  if (any_wrong(of_scanner)) {
    append(result.findings, std::move(of_scanner));
    return result;
  }

  CheckSettings with_motion = settings;
  with_motion.moving = settings.moving || measuring_band(model.layout()).cycle.has_value();
  if (samples.groups() < ScanSamples::fewest_groups) return result;

  // If the frames are noise, all other findings would mislead. Saturated pixels hardly change with
  // their neighbours either.
  constexpr double mostly_saturated = 0.2;
  if (samples.saturated_share() <= mostly_saturated) {
    if (auto noise = unrelated_pixels(samples)) {
      return {.findings = {std::move(*noise)}, .order = {}};
    }
  }

  // 3. Whether frames, sequence and scanner fit together, and if not, why.
  const auto judged_by = [&](const Scanner* known) {
    ScanFindings judged = result;
    judge({model, samples, sequence, known, photometry, with_motion}, of_scanner, judged);
    return judged;
  };
  auto padded = scanner ? padded_pictures(frames, scanner->camera) : std::nullopt;
  if (padded) {
    // The scanner is one of other pictures: only findings of the frames alone help beside it.
    if (any_wrong(judged_by(&*scanner).findings)) padded->severity = Severity::wrong;
    result = judged_by(nullptr);
    result.findings.insert(result.findings.begin(), std::move(*padded));
  } else {
    result = judged_by(scanner ? &*scanner : nullptr);
  }

  // 4. Levels that wrapped around are named only if no other cause is clear.
  const bool unclear = std::ranges::any_of(
      result.findings, [](const Finding& finding) { return blames(finding, CauseKind::unclear); });
  if (!unclear) return result;

  if (auto wrapped = wrapped_levels(model.layout(), samples)) {
    result.findings = {std::move(*wrapped)};
  }
  return result;
}

ScanFindings check_scan(const Scan& scan, const CheckSettings& settings) {
  CheckSettings with_order = settings;
  with_order.order = scan.order;
  return check_frames(scan.frames, scan.sequence, scan.scanner, with_order);
}

CheckedScan check_and_repair(Scan& scan, const CheckSettings& settings) {
  CheckedScan checked;
  check_camera(scan, settings, "", checked);
  for (std::size_t i = 0; i < scan.further_cameras.size(); ++i) {
    check_camera(scan.further_cameras[i], settings, fmt::format("camera {}", i + 2), checked);
  }

  // A gamma that bends the phase by less than noise needs no correction.
  const bool matters = std::ranges::any_of(checked.findings, [](const Finding& finding) {
    return std::ranges::count(finding.causes, CauseKind::gamma, &Cause::kind) > 0;
  });

  const auto& blind = settings.blind;
  if (matters && blind && !blind->accepted() && blind->refusal != BlindRefusal::no_distortion) {
    checked.findings.push_back(
        {.kind = FindingKind::blind_gamma_refused,
         .what = fmt::format("`gamma blind` corrects nothing: {}", reason_of(blind->refusal)),
         .evidence = {{"best fit", blind->gamma}, {"standard error", blind->standard_error}},
         .causes = {{CauseKind::gamma, "the projector's gamma, if it is not 1"}},
         .remedies = {{"measure it with `calibrate_gamma()`, or give `gamma` a number"}}});
  }

  if (!scan.further_cameras.empty()) {
    checked.findings = without_cause(std::move(checked.findings), CauseKind::gamma);
  }

  return checked;
}

void require_right(const CheckedScan& checked, const std::string& scan, std::size_t from) {
  const auto first = checked.findings.begin() + static_cast<std::ptrdiff_t>(from);
  const std::vector<Finding> later(first, checked.findings.end());
  if (!any_wrong(later)) return;

  std::vector<std::string> texts;
  for (const Finding& finding : gravest_first(later)) texts.push_back(text_of(finding));

  throw RefusedScan(fmt::format("{}: {}", scan, fmt::join(texts, " | ")),
                    gravest_first(checked.findings));
}

std::vector<std::string> doubts(const std::vector<Finding>& findings) {
  std::vector<std::string> lines;
  for (const Finding& finding : findings) {
    if (finding.severity == Severity::wrong) {
      lines.push_back(fmt::format("doubted: {}", text_of(finding)));
    }
  }

  return lines;
}

}  // namespace slipstream
