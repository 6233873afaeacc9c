#include "slipstream/scan_job.h"

#include <algorithm>
#include <future>
#include <iterator>
#include <numeric>
#include <utility>

#include <fmt/format.h>

#include "base/parallel_rows.h"
#include "base/stopwatch.h"
#include "base/throw_if-inl.h"
#include "reconstruct/coordinate_map.h"
#include "reconstruct/coordinate_matcher.h"
#include "reconstruct/engine_setup.h"
#include "reconstruct/epipolar.h"
#include "reconstruct/phase_matcher.h"
#include "scan_job/axis_findings.h"
#include "scan_job/error_budget.h"
#include "scan_job/fused_cameras.h"
#include "scan_job/scan_colours.h"

namespace slipstream {
namespace {

/// Two cameras match any phase, so no response is needed.
GammaChoice choose_response_for(Scan& scan, const ScanJobSettings& settings) {
  GammaChoice choice = choose_response(scan, settings.gamma);
  if (scan.further_cameras.empty()) return choice;
  return {.source = "two cameras", .sentence = "two cameras, independent of gamma"};
}

/// Replaces the ambient light and the noise that are set in `settings`.
void replace_light(PhotometricCalibration& known, const PhotometricCalibration& settings) {
  if (settings.ambient) known.ambient = settings.ambient;
  if (!settings.noise_variance) return;

  known.noise_variance = settings.noise_variance;
  if (settings.noise_gain > 0) known.noise_gain = settings.noise_gain;
}

/// Gives the scan's scanner the ambient light and the noise that `settings` has, and returns its
/// photometric calibration; without a scanner, returns `settings`.
PhotometricCalibration set_light(Scan& scan, const PhotometricCalibration& settings) {
  if (!scan.scanner) return settings;
  replace_light(scan.scanner->photometry, settings);
  return scan.scanner->photometry;
}

/// Checks a scan and puts slipped frames in order; then `gamma` is chosen again. `known`: light and
/// response of a scan without a scanner.
CheckedScan checked_frames(Scan& scan, const ScanJobSettings& settings,
                           const PhotometricCalibration& known, GammaChoice& gamma) {
  CheckedScan checked =
      check_and_repair(scan, {.minimum_modulation = settings.reconstruct.minimum_modulation,
                              .moving = settings.moving,
                              .photometry = known,
                              .blind = gamma.blind});
  if (!checked.repairs.empty()) gamma = choose_response_for(scan, settings);
  return checked;
}

/// The pair with the light and noise that the settings give, else those of its file.
Scanner pair_of(const Scan& scan, const PhotometricCalibration& settings, const std::string& name) {
  Scanner pair = completed(*scan.camera_pair, name + ", the second camera as the projector",
                           scan.frames.size(), scan.further_cameras.front().frames.size());

  replace_light(pair.photometry, settings);
  pair.photometry.response.reset();
  return pair;
}

/// A setup without geometry: for maps, and for the check of a camera pair.
EngineSetup setup_for_maps(const Scan& scan, const ScanJobSettings& settings,
                           const PhotometricCalibration& known, const std::string& name) {
  EngineSetup setup{without_geometry(scan.frames.size(), scan.sequence.projector, known),
                    scan.sequence, settings.reconstruct};
  require_ambient_known(setup, name);
  return setup;
}

/// Compares a cloud and its maps with the scan's guard.
GuardResult judged_guard(const EngineSetup& setup, Scan guard, const Maps& maps,
                         const Cloud& cloud) {
  GuardResult result;

  // 1. A guard whose own frames do not fit would blame the rig.
  const CheckedScan checked =
      check_and_repair(guard, {.minimum_modulation = setup.settings.minimum_modulation,
                               .photometry = setup.scanner.photometry});
  for (Finding finding : checked.findings) {
    if (finding.severity != Severity::wrong) continue;
    finding.severity = Severity::doubtful;
    finding.subject = "guard";
    result.findings.push_back(std::move(finding));
  }
  if (!result.findings.empty()) return result;

  // 2. The comparison.
  const GuardCheck check = check_guard(setup, guard, maps, cloud);
  if (check.epipolar.points > 0) result.epipolar = check.epipolar;
  if (auto finding = rig_that_moved(setup.scanner, check)) {
    result.findings.push_back(*std::move(finding));
  }
  return result;
}

/// One band of many periods leaves the fringe order open, and the cameras do not decide it.
Finding undecided_order() {
  return {
      .kind = FindingKind::camera_orders_disagree,
      .what = "the two cameras leave the fringe order of most surfaces open",
      .causes = {{CauseKind::depth_range, "several fringe orders fit, and no depth range is set"},
                 {CauseKind::rig_moved, "cameras that moved since calibration"}},
      .remedies = {{"set the depths, mm, between which everything lit lies, e.g. "
                    "`nearest 500` `farthest 700`"}}};
}

/// A remedy if most pixels are rejected for that reason.
std::string advice_on(Validity most) {
  switch (most) {
    case Validity::too_dark:
      return "lengthen the exposure, darken the room, or lower `minimum_modulation`";
    case Validity::saturated:
      return "shorten the exposure, or take several with `exposures`";
    case Validity::doubtful_order:
      return "take more light or fewer periods, and check that nothing moved";
    case Validity::no_point:
    case Validity::outside_field:
      return "check the scanner file and the projector's size";
    case Validity::out_of_range:
      return "check the depth range, `nearest` and `farthest`";
    case Validity::outside_region:
      return "check the region, `box` and `outline`";
    case Validity::moved:
      return "hold the object still";
    default:
      return "see which points come without cleaning: `raw`";
  }
}

/// No point, or under half of the pixels that are lit and within the user's limits.
std::optional<Finding> missing_points(ValidityCounts counts, const ReconstructSettings& settings) {
  const std::size_t points = counts.front();

  // Pixels that the user excludes do not count, nor dark ones.
  const auto ignore = [&](Validity kind, bool if_true = true) {
    if (if_true && points > 0) counts[static_cast<std::size_t>(kind)] = 0;
  };
  ignore(Validity::too_dark);
  ignore(Validity::outside_region);
  ignore(Validity::out_of_range, settings.nearest || settings.farthest);
  ignore(Validity::low_trust, settings.clean.largest_sigma.has_value());

  const std::size_t lit = std::accumulate(counts.begin(), counts.end(), std::size_t{0});
  if (2 * points >= lit) return std::nullopt;

  const auto most =
      static_cast<Validity>(std::max_element(counts.begin() + 1, counts.end()) - counts.begin());
  return Finding{
      .kind = FindingKind::few_points,
      .severity = points == 0 ? Severity::wrong : Severity::doubtful,
      .what = points == 0 ? "not one pixel became a point"
                          : "under 50 % of the lit pixels became points",
      .evidence = {{"share", static_cast<double>(points) / static_cast<double>(lit)}},
      .causes = {{CauseKind::rejected_pixels, fmt::format("most are rejected: {}", name_of(most))}},
      .remedies = {{advice_on(most)}}};
}

/// Counts the pixels that contrast had pulled, if that was corrected.
void count_pulled(ScanResult& result) {
  const Image<float>& pull = result.maps.contrast;
  if (pull.empty()) return;
  result.pulled_pixels = std::ranges::count_if(pull, [](float taken) { return taken != 0; });
}

/// Counts the pixels by validity; warns of missing points.
void count(ScanResult& result, const ReconstructSettings& settings, ScanOutput output) {
  result.counts = count_by_validity(result.cloud.validity);
  if (output == ScanOutput::maps) return;

  if (auto missing = missing_points(result.counts, settings)) {
    result.checked.findings.push_back(*std::move(missing));
  }
}

/// Throws Error: without a scanner there are no points; or RefusedScan if the frames alone show
/// that something else is wrong.
[[noreturn]] void refuse_without_scanner(Scan& scan, const ScanJobSettings& settings,
                                         const std::string& name) {
  require_right(check(scan, settings).checked, name);
  throw Error(
      fmt::format("{}: no scanner is known; name its file with `scanner` or in scan.yaml. Without "
                  "one the frames give `phase FILE`, `modulation FILE` and `preview FILE`",
                  name));
}

}  // namespace

CheckedJob checked_camera(Scan scan, const ScanJobSettings& settings, const std::string& name) {
  const bool has_pair = settings.output == ScanOutput::points && !scan.scanner &&
                        scan.camera_pair && !scan.further_cameras.empty();
  const bool wants_points = settings.output == ScanOutput::points && !has_pair;
  if (wants_points && !scan.scanner) refuse_without_scanner(scan, settings, name);

  Stopwatch watch;
  CheckedJob job{.scan = std::move(scan)};
  PhotometricCalibration known = set_light(job.scan, settings.photometry);
  std::optional<Scanner> pair;
  if (has_pair) {
    pair = pair_of(job.scan, settings.photometry, name);
    known = pair->photometry;
  }

  // 1. The response, and the setup of the engine that reads the frames.
  job.gamma = choose_response_for(job.scan, settings);
  if (wants_points) {
    job.setup = setup_for(job.scan, settings.reconstruct);
  } else {
    known.response = job.gamma.response;
    job.setup = setup_for_maps(job.scan, settings, known, name);
  }
  job.choosing = watch.lap();
  if (wants_points) {
    if (job.scan.further_cameras.empty()) {
      require_reconstructible(job.setup);
    } else {
      require_valid(job.setup);
    }
  }

  // 2. The check, which may put the frames in another order; then the response may differ.
  job.checked = checked_frames(job.scan, settings, job.setup.scanner.photometry, job.gamma);

  if (pair) job.setup.scanner = *pair;
  if (!pair) job.setup.scanner.photometry.response = job.gamma.response;
  job.checking = watch.lap();
  return job;
}

ScanCheck check(Scan& scan, const ScanJobSettings& settings) {
  PhotometricCalibration known = set_light(scan, settings.photometry);
  GammaChoice gamma = choose_response_for(scan, settings);
  known.response = gamma.response;

  ScanCheck result{.checked = checked_frames(scan, settings, known, gamma)};
  if (any_wrong(result.checked.findings)) return result;

  GuardResult guard = compare_with_guard(scan, settings.reconstruct);
  result.guard = guard.epipolar;
  std::ranges::move(guard.findings, std::back_inserter(result.checked.findings));
  return result;
}

ScanJob::ScanJob(ScanJobSettings settings) : settings_(std::move(settings)) {}

ScanResult ScanJob::operator()(Scan scan, const std::string& name) {
  return (*this)(checked_job(std::move(scan), settings_, name), name);
}

void ScanJob::match_cameras(const CheckedJob& job, ScanResult& result) {
  const Scan& scan = job.scan;
  const Scan& second = scan.further_cameras.front();
  const EngineSetup& setup = job.setup;
  throw_if(scan.further_cameras.size() > 1, "two cameras can be matched, not {}",
           1 + scan.further_cameras.size());
  require_matchable(setup.settings);

  // 1. Without a calibrated projector, places with equal coordinates match.
  if (!scan.scanner) {
    CoordinateMatcher::Result matched =
        CoordinateMatcher(setup.scanner, setup.sequence, setup.settings)(scan);
    result.cloud = std::move(matched.cloud);
    result.maps = std::move(matched.maps);
    if (settings_.uncertainty) result.uncertainty = std::move(matched.uncertainty);
    result.backend = "coordinates";
    return;
  }

  // 2. With one, phases match along epipolar lines, Liu 2010, Section 4.4.
  throw_if(!second.scanner,
           "the second camera's scanner is unknown; name its file with `second_scanner`");
  PhaseMatcher match(setup.scanner, setup_for(second).scanner, setup.sequence, setup.settings,
                     {.window = settings_.match_window});
  PhaseMatcher::Result matched = match(scan, second);

  // 3. Findings about the phase's origin and the fringe order.
  std::vector<Finding>& findings = result.checked.findings;
  const bool limited = setup.settings.nearest && setup.settings.farthest;
  if (matched.agreement && matched.agreement->phase_shift != 0) {
    findings.push_back(wrong_origin(setup.sequence.strategy, matched.agreement->phase_shift));
  } else if (!matched.agreement && !has_coordinate(setup.sequence.strategy) && !limited) {
    findings.push_back(undecided_order());
  }

  result.cloud = std::move(matched.cloud);
  result.maps = std::move(matched.maps);
  result.backend = match.method_for(scan.frames);
}

void ScanJob::compute(const CheckedJob& job, ScanResult& result) {
  const Scan& scan = job.scan;
  Engine& engine = *engine_;

  if (settings_.output == ScanOutput::maps) {
    engine.maps(scan.frames, result.maps);
    result.cloud = Cloud();
    result.cloud.validity =
        picture_report(engine.merged(scan.frames), result.maps, engine.setup().settings).validity;
  } else if (!scan.other_axis.empty()) {
    engine.cloud_and_maps(scan.frames, result.cloud, result.maps);
    result.epipolar =
        check_epipolar(engine.setup(), scan.other_axis.front(), result.maps, result.cloud);
  } else if (settings_.maps || settings_.uncertainty || job.fuses || settings_.sure_coordinates ||
             !scan.guard.empty() || engine.setup().settings.correct_contrast) {
    engine.cloud_and_maps(scan.frames, result.cloud, result.maps);
  } else {
    engine.cloud(scan.frames, result.cloud);
  }

  count_pulled(result);

  result.backend = engine.backend_for(scan.frames);
  result.fallback_reason = engine.fallback_reason();
  if (settings_.output == ScanOutput::maps) return;

  // Both axes, or the guard, against the scanner.
  std::vector<Finding>& findings = result.checked.findings;
  if (result.epipolar) {
    const double calibration_rms = engine.setup().scanner.calibration_rms;
    auto finding = axes_that_disagree(*result.epipolar, calibration_rms);
    if (finding) findings.push_back(*std::move(finding));
  } else if (!scan.guard.empty()) {
    GuardResult guard = judged_guard(engine.setup(), scan.guard.front(), result.maps, result.cloud);
    result.guard = guard.epipolar;
    std::ranges::move(guard.findings, std::back_inserter(findings));
  }
}

ScanResult ScanJob::operator()(const CheckedJob& job, const std::string& name) {
  ScanResult result = result_of(job, name);
  if (job.fuses) fuse_cameras(job, name, result);
  return result;
}

ScanResult ScanJob::result_of(const CheckedJob& job, const std::string& name) {
  if (!settings_.keep_refused) require_right(job.checked, name);

  const EngineSetup& setup = job.setup;
  const bool two_cameras =
      !job.scan.further_cameras.empty() && settings_.output == ScanOutput::points;

  // Points that are fused are weighted by their noise; those of matched cameras get theirs later.
  const bool wants_uncertainty = job.fuses ? !two_cameras : settings_.uncertainty;
  throw_if(wants_uncertainty && two_cameras && job.scan.scanner,
           "the uncertainty is known of one camera and the projector, not of two cameras");

  ScanResult result{.setup = setup,
                    .gamma = job.gamma,
                    .checked = job.checked,
                    .choosing = job.choosing,
                    .checking = job.checking};
  if (!clouds_.empty()) {
    result.cloud = std::move(clouds_.back());
    clouds_.pop_back();
  }

  // 1. Tables of the engine, unless the last scan's serve. Meanwhile the cloud's memory, whose
  // pages take as long to get.
  Stopwatch watch;
  auto memory =
      std::async(parallel_threads() == 1 ? std::launch::deferred : std::launch::async, [&] {
        const Size size = job.scan.frames.size();
        if (result.cloud.size() != size) result.cloud = Cloud(size);
      });
  result.least_modulation =
      two_cameras ? setup.settings.minimum_modulation : least_modulation(setup);
  if (!two_cameras && (!engine_ || engine_->setup() != setup)) engine_.emplace(setup);
  result.tables = watch.lap();
  memory.get();

  // 2. Points or maps.
  if (two_cameras) {
    match_cameras(job, result);
  } else {
    compute(job, result);
  }
  if (settings_.output == ScanOutput::points) {
    result.cloud.colour = colours_of(result.cloud, job.scan);
  }
  count(result, setup.settings, settings_.output);
  result.computing = watch.lap();
  if (!settings_.keep_refused) {
    require_right(result.checked, name, job.checked.findings.size());
  }

  // 3. Uncertainty and confirmed coordinates, if wanted.
  if (wants_uncertainty && !result.uncertainty) {
    result.uncertainty = engine_->uncertainty(result.cloud, result.maps, job.scan.frames);
    if (settings_.uncertainty) result.budget = error_budget(result, job.scan.frames);
  }
  if (settings_.sure_coordinates && !two_cameras) {
    result.maps.coordinate =
        converted<float>(measured_coordinates(*engine_, job.scan.frames, result.maps));
  }
  return result;
}

GuardResult compare_with_guard(const Scan& scan, const ReconstructSettings& settings) {
  const bool is_possible = !scan.guard.empty() && scan.other_axis.empty() && scan.scanner &&
                           has_coordinate(scan.sequence.strategy);
  if (!is_possible) return {};

  Engine engine(setup_for(scan, settings));
  Cloud cloud;
  Maps maps;
  engine.cloud_and_maps(scan.frames, cloud, maps);
  return judged_guard(engine.setup(), scan.guard.front(), maps, cloud);
}

Uncertainty ScanJob::uncertainty_of(const ScanResult& result, const FrameViews& frames) {
  if (!engine_ || engine_->setup() != result.setup) engine_.emplace(result.setup);
  Maps maps;
  engine_->maps(frames, maps);
  return engine_->uncertainty(result.cloud, maps, frames);
}

ScanResult reconstruct(Scan scan, const ScanJobSettings& settings) {
  return ScanJob(settings)(std::move(scan));
}

ScanResult reconstruct_map(const Image<double>& coordinates, const EngineSetup& setup,
                           const Image<float>& modulation, CheckedScan checked) {
  Stopwatch watch;
  ScanResult result{.setup = setup, .checked = std::move(checked), .backend = "reference"};
  result.cloud = cloud_of_coordinates(coordinates, setup, modulation, &result.maps);
  count_pulled(result);
  count(result, setup.settings, ScanOutput::points);
  result.computing = watch.lap();
  return result;
}

}  // namespace slipstream
