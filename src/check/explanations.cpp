#include "check/explanations.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "check/changing_light.h"
#include "check/code_evidence.h"
#include "check/contradicting_frame.h"
#include "check/dark_frames.h"
#include "check/displaced_frames.h"
#include "check/frame_faults.h"
#include "check/method_limits.h"
#include "check/mistake_search.h"
#include "check/out_of_step.h"

namespace slipstream {
namespace {

/// The symptom of a code that exceeds its limit most, relative to it.
const CodeSymptom& worst_symptom(const CodeEvidence& code) {
  return *std::ranges::max_element(code_symptoms, {}, [&](const CodeSymptom& symptom) {
    return std::abs(code.*symptom.value) / symptom.limit;
  });
}

/// A symptom without a cause yet.
Finding symptom(FindingKind kind, std::string what, std::vector<Evidence> evidence) {
  return {.kind = kind,
          .severity = Severity::wrong,
          .what = std::move(what),
          .evidence = std::move(evidence)};
}

Finding pattern_mismatch(const Fit& fit) {
  const double limit = fit.moving ? FitLimits::most_residual_moving : FitLimits::most_residual;
  return symptom(
      FindingKind::pattern_mismatch,
      fmt::format(
          "the frames do not match the patterns: over {:g} % of their variation is unexplained",
          100 * limit),
      {{.name = "unexplained share of the variation",
        .value = fit.frames.residual,
        .limit = limit}});
}

Finding contradicting_code(const CodeEvidence& code) {
  const CodeSymptom& worst = worst_symptom(code);
  return symptom(
      worst.kind, fmt::format(fmt::runtime(worst.what), 100 * worst.limit),
      {{.name = std::string(worst.quantity), .value = code.*worst.value, .limit = worst.limit}});
}

Finding unrelated_modulations(const FrameEvidence& frames) {
  constexpr double limit = FitLimits::most_ratio_spread;
  return symptom(
      FindingKind::unrelated_modulations,
      fmt::format(
          "the bands' modulations do not vary together: the spread of their ratio is above {:g}",
          limit),
      {{.name = "spread of their modulations' ratio",
        .value = frames.ratio_spread,
        .limit = limit}});
}

Finding fringe_orders_disagree(const Fit& fit) {
  Finding finding = symptom(
      FindingKind::fringe_orders_disagree,
      fmt::format(
          "the frames disagree about the fringe order: agreement below {:g} or offset above {:g}",
          FitLimits::least_agreement, FitLimits::most_offset),
      {});

  if (const BandRelation* const worst = fit.worst_relation()) {
    finding.evidence = {
        {.name = "agreement", .value = worst->agreement, .limit = FitLimits::least_agreement},
        {"offset", worst->offset, "periods", FitLimits::most_offset}};
  }
  return finding;
}

Finding coordinate_jumps(const FrameEvidence& frames) {
  constexpr double limit = FitLimits::most_seams;
  return symptom(
      FindingKind::coordinate_jumps,
      fmt::format(
          "the coordinate jumps across the whole field in over {:g} % of the lit pixel pairs",
          100 * limit),
      {{.name = "share of the pixels near it", .value = frames.seams, .limit = limit}});
}

/// The clearest symptom of a scan that does not fit: of the first test that fails, the most basic
/// one first.
Finding seen(const Fit& fit) {
  if (!fit.patterns_made()) return pattern_mismatch(fit);
  if (!fit.code_agrees()) return contradicting_code(fit.code);
  if (!fit.bands_alike()) return unrelated_modulations(fit.frames);
  if (!fit.bands_agree()) return fringe_orders_disagree(fit);
  if (!fit.no_seam()) return coordinate_jumps(fit.frames);
  if (!fit.geometry_fits()) return geometry_mismatch(*fit.geometry, "frames");
  return depths_beyond_boards(*fit.geometry);
}

/// Whether the code's edges move along the field against the phase.
bool is_drift(const CodeSymptom& worst, const CodeEvidence& code) {
  const bool by_edges =
      worst.value == &CodeEvidence::offset || worst.value == &CodeEvidence::incoherence;
  return by_edges && code.drifts();
}

/// Names stripes that are not as wide as the layout says.
void name_drift(const CodeEvidence& code, const Layout& layout, Finding& finding) {
  finding.evidence.push_back({"change across the field", code.drift, "periods"});

  // A code whose stripes have a width of their own: that width, or the periods, are others.
  // By default there are 1, 2, 4, ... per period.
  const double doublings = std::log2(layout.code->stripes / measuring_band(layout).periods);
  if (std::abs(doublings - std::round(doublings)) > 1e-9) {
    finding.causes = {{CauseKind::pattern_settings,
                       "stripes of the code that are not as wide as given, or another number of "
                       "periods"}};
    finding.remedies = {{"take `stripes` and `periods` from the patterns"}};
    return;
  }

  // By default the bit of half a stripe tolerates a quarter of a period.
  finding.severity = Severity::doubtful;
  finding.causes = {{CauseKind::pattern_settings,
                     "stripes of the code that are not as wide as a period, as when a width was "
                     "rounded to whole pixels"}};
  finding.remedies = {
      {"give the number of stripes (`stripes`), or project stripes as wide as the periods; "
       "until then the fringe order is right only where code and phase differ by less than a "
       "quarter of a period"}};
}

/// Whether too few points can be right: most lie outside the light, or the coordinate runs back.
bool is_hopeless(const GeometryEvidence& geometry) {
  constexpr double most_outside = 0.6;
  return geometry.slope + geometry.slope_doubt < 0 ||
         geometry.outside + geometry.without_point > most_outside;
}

Cause unknown_gamma() {
  return {CauseKind::gamma, "the projector's gamma, if it is not 1"};
}

/// Whether frames show products of sinusoids: no correction of the response applies to them.
bool shows_products(const Layout& layout) {
  return std::ranges::any_of(layout.bands,
                             [](const Band& band) { return band.carrier > 0 && !bent_run(band); });
}

/// Names broad causes of frames that do not fit.
void name_frames_broadly(const JudgedScan& scan, const Fit& fit, Finding& finding) {
  // Beyond these, too few pixels are right to separate them from wrong ones.
  constexpr double hopeless_agreement = 0.35, hopeless_offset = 0.25;
  // More would have been explained by a gamma.
  constexpr double most_by_gamma = 0.2;

  const auto hopeless = [](const BandRelation& relation) {
    return !relation.agrees() &&
           (relation.agreement < hopeless_agreement || std::abs(relation.offset) > hopeless_offset);
  };
  const auto& relations = fit.frames.relations;
  // Bands that agree have the right settings and order.
  const bool is_right_order = !relations.empty() && fit.has_evidence() && fit.bands_agree() &&
                              fit.code_agrees() && fit.no_seam();

  // Harmonics of a response stay in products, in right frames, too: up to 0.4 in harsh light.
  const bool by_response =
      shows_products(scan.model.layout()) && is_right_order && fit.geometry_fits();
  const bool is_hopeless = fit.frames.residual > FitLimits::hopeless_residual && !by_response;
  if (is_hopeless || std::ranges::any_of(relations, hopeless)) finding.severity = Severity::wrong;

  finding.remedies = {{"compare the frames with the output of `patterns()`"}};

  // If bands differ by the same share of a period everywhere, the shifts of some begin elsewhere.
  constexpr double nearly_everywhere = 0.9;
  const auto is_constant = [](const BandRelation& relation) {
    return relation.agreement >= nearly_everywhere;
  };
  if (fit.patterns_made() && !fit.bands_agree() && std::ranges::all_of(relations, is_constant)) {
    finding.causes = {
        {CauseKind::pattern_settings, "another origin or direction of the shifts than configured"},
        {CauseKind::frame_order, "frames rotated within a band"}};
    return;
  }

  finding.causes = {{CauseKind::unclear,
                     "wrong pattern settings, lost or mixed-up frames, or motion during capture"}};
  if (by_response) {
    finding.causes.insert(finding.causes.begin(), unknown_gamma());
    finding.remedies.insert(finding.remedies.begin(),
                            {"project patterns that compensate for the gamma"});
    return;
  }
  if (scan.photometry.response || fit.frames.residual > most_by_gamma) return;
  finding.causes.push_back(unknown_gamma());

  // A response is likelier than wrong settings or another order.
  if (!is_right_order || finding.severity == Severity::wrong) return;
  std::ranges::reverse(finding.causes);
  finding.remedies.insert(finding.remedies.begin(), {"measure the gamma with `calibrate_gamma()`"});
}

/// Names a broad cause if no common mistake explains the misfit.
void name_broadly(const JudgedScan& scan, const Fit& fit, Finding& finding) {
  const auto& geometry = fit.geometry;
  const auto blame = [&](CauseKind kind, std::string_view text) {
    finding.causes.push_back({kind, std::string(text)});
  };

  finding.severity = Severity::doubtful;
  if (fit.patterns_made() && !fit.code_agrees()) {
    const CodeSymptom& worst = worst_symptom(fit.code);
    if (std::abs(fit.code.*worst.value) > 2 * worst.limit) finding.severity = Severity::wrong;

    if (is_drift(worst, fit.code)) return name_drift(fit.code, scan.model.layout(), finding);
    for (const auto& [kind, text] : worst.causes) {
      if (!text.empty()) blame(kind, text);
    }
    if (worst.value == &CodeEvidence::doubt && !scan.photometry.response) {
      finding.causes.push_back(unknown_gamma());
    }
    finding.remedies = {{fmt::format("{} the output of `patterns()`", worst.compare)}};
  } else if (fit.frames.damping > 0) {
    finding.evidence.push_back(
        {"fringes fainter than the cue by", 100 * fit.frames.damping, "percent"});
    blame(CauseKind::blur,
          "fringes blurred by a lens or by too few pixels per period: fringe orders at the ends of "
          "the field are wrong");
    finding.remedies = {{"focus both lenses, use larger pictures or fewer periods (`high`)"}};
  } else if (!fit.frames_fit()) {
    name_frames_broadly(scan, fit, finding);
  } else if (!fit.geometry_fits()) {
    if (is_hopeless(*geometry)) finding.severity = Severity::wrong;
    blame(CauseKind::unclear,
          "a scanner file of another rig, pictures cropped or of another size, or a camera or "
          "projector that moved since calibration");
    finding.remedies = {{"check the scanner file; if the rig moved, run `calibrate_geometry()`"}};
  } else {
    finding.causes = {beyond_the_boards()};
    blame(CauseKind::other_rig, "a scanner file of another rig");
    finding.remedies = {{"calibrate with boards at those depths, or check the frame order"}};
  }
}

/// Finding about frames that fit: the pictures are an unknown part of the calibrated ones.
std::optional<Finding> cropped_pictures(const JudgedScan& scan, const Fit& fit) {
  if (!fit.has_stray_points() || !is_off_centre(scan.scanner->camera)) return std::nullopt;

  const Lens& camera = scan.scanner->camera;
  return Finding{
      .kind = FindingKind::off_centre_camera,
      .what =
          "points lie outside the projector's light, and the camera's optical axis far from the "
          "centre of its pictures",
      .evidence = {{"share of the width", camera.intrinsic(0, 2) / camera.size.width},
                   {"share of the height", camera.intrinsic(1, 2) / camera.size.height},
                   {"share outside the projector's light", fit.geometry->outside}},
      .causes = {{CauseKind::picture_size, "pictures cropped or of another size"}},
      .remedies = {{"say which part of the calibrated pictures they are with `camera_region`"}}};
}

/// Finding about a scan that fits: another mistake explains it far better.
std::optional<Finding> better_fit(const JudgedScan& scan, const Fit& fit) {
  constexpr double clearly = 0.5;
  auto better = fit.poor() ? likeliest_mistake(scan, fit) : std::nullopt;
  if (!better) return cropped_pictures(scan, fit);

  // Depths beyond the boards may be the scene's own: on their own they prove no mistake.
  const double beyond = fit.geometry ? fit.geometry->beyond : 0;
  const bool by_depths_alone = fit.misfit() - beyond < better->misfit + clearly;

  Finding finding{.kind = FindingKind::better_settings,
                  .severity = by_depths_alone ? Severity::doubtful : Severity::wrong,
                  .what = "the scan would fit far better with other settings",
                  .evidence = {{"misfit", fit.misfit()}, {"misfit then", better->misfit}}};

  give_causes(*better, finding);
  if (by_depths_alone) finding.causes.push_back(beyond_the_boards());
  if (fit.geometry) finding.evidence.push_back({"median depth", fit.geometry->median_depth, "mm"});

  return finding;
}

/// One frame that contradicts the others, or several that have moved.
std::optional<Finding> unlike_frames(const JudgedScan& scan, const Fit& fit) {
  // A frame of another brightness moves no bit that is compared with its inverse.
  auto odd = fit.code.bits_are_sure() ? std::nullopt : contradicting_frame(scan, fit);
  return odd ? odd : displaced_frames(scan, fit);
}

/// Faults that a scan may hide although it fits.
std::vector<Finding> remaining_faults(const JudgedScan& scan, const Fit& fit,
                                      std::optional<MixedFrames> mixed,
                                      std::optional<ChangedLight> light) {
  if (mixed) return {std::move(mixed->finding)};

  // With redundancy, a dark frame would not have fitted.
  if (!scan.model.has_redundancy()) {
    if (std::vector<Finding> dark = dark_frames(scan); !dark.empty()) return dark;
  }

  // Then the mistakes that are harder to see, and last the limits of the method.
  if (light) return {std::move(light->finding)};

  // Pixels that scatter, as of one-bit patterns in focus, fit other settings by chance.
  std::vector<Finding> findings = method_limits(scan, fit);
  const bool scatters = std::ranges::any_of(
      findings, [](const Finding& finding) { return finding.kind == FindingKind::excess_noise; });
  if (!scatters) {
    if (auto better = better_fit(scan, fit)) return {std::move(*better)};
    if (auto unlike = unlike_frames(scan, fit)) return {std::move(*unlike)};
  }

  if (auto of_code = changed_light_of_code(scan)) findings.push_back(std::move(*of_code));
  if (!findings.empty()) return findings;

  if (auto apart = contradicting_frames(scan, fit)) findings.push_back(std::move(*apart));
  return findings;
}

/// Two explanations whose misfits differ by less explain a scan about as well.
constexpr double nearly = 0.3;

/// Takes over the likeliest mistake, and names others that explain the scan about as well: frames
/// that contain a share of another, and dark ones.
void name_mistake(Explanation explanation, bool only_depths,
                  const std::optional<MixedFrames>& mixed, std::vector<Finding> dark,
                  ScanFindings& result, Finding& finding) {
  if (only_depths) {
    explanation.severity = Severity::doubtful;
    explanation.causes.push_back(beyond_the_boards());
  }

  give_causes(explanation, finding);
  finding.severity = explanation.severity;

  // Set if the cycle has slipped: the caller then reorders the frames.
  result.order = std::move(explanation.order);
  if (!result.order.empty()) result.median_depth = explanation.median_depth;

  if (mixed && mixed->misfit < explanation.misfit + nearly) dark.push_back(mixed->finding);
  for (const Finding& fault : dark) {
    std::ranges::copy(fault.causes, std::back_inserter(finding.causes));
  }
}

/// Adds the symptom of a scan that does not fit, and the likeliest cause, or a broad one if no
/// specific one explains it.
void explain_misfit(const JudgedScan& scan, const Fit& fit, std::optional<MixedFrames> mixed,
                    std::optional<ChangedLight> light, ScanFindings& result) {
  Finding finding = seen(fit);
  const bool only_depths = fit.frames_fit() && fit.geometry_fits();
  const bool response_known = scan.photometry.response.has_value();

  // 1. Common mistakes; a doubtful scanner explains a misfit of the geometry already.
  if (scan.scanner_doubted && fit.frames_fit()) {
    name_broadly(scan, fit, finding);
    if (!only_depths) finding.severity = Severity::wrong;
    result.findings.push_back(std::move(finding));
    return;
  }

  // Frames that show stripes of one bit, or an S-curve, are the right ones.
  const bool of_stripes =
      fit.waveform && fit.waveform->is_odd() && fit.waveform->residual <= FitLimits::most_residual;
  if (of_stripes && !fit.patterns_made() && fit.bands_agree()) {
    finding.severity = Severity::doubtful;
    finding.causes = {{CauseKind::noise, "one-bit patterns in focus"}};
    finding.remedies = {{"defocus the projector or show 8-bit patterns"}};
    if (!response_known) {
      finding.causes.insert(finding.causes.begin(),
                            {CauseKind::gamma, "an S-curve of the response"});
      finding.remedies.insert(finding.remedies.begin(), {"measure it with `calibrate_gamma()`"});
    }
    result.findings.push_back(std::move(finding));
    return;
  }

  auto explanation = likeliest_mistake(scan, fit);

  // 2. Frames without a pattern.
  constexpr double contradicting = 0.2;  // so far off that a frame may be lost
  const bool turns_back = fit.geometry && fit.geometry->falling > fit.most_falling();
  const bool is_lost = !fit.code_agrees() || turns_back ||
                       (scan.model.unexplained_count() > 0 && fit.frames.residual >= contradicting);
  std::vector<Finding> dark = dark_frames(scan, is_lost);

  // 3. The likeliest of all.
  const bool by_light =
      light && dark.empty() && (!explanation || light->misfit < explanation->misfit - nearly);
  if (mixed && dark.empty() && (!explanation || mixed->misfit < explanation->misfit - nearly)) {
    finding = std::move(mixed->finding);
  } else if (by_light) {
    finding = std::move(light->finding);
  } else if (explanation) {
    name_mistake(*std::move(explanation), only_depths, mixed, std::move(dark), result, finding);
  } else if (!dark.empty()) {
    result.findings = std::move(dark);
    return;
  } else {
    name_broadly(scan, fit, finding);
    auto unlike = fit.patterns_made() ? std::nullopt : unlike_frames(scan, fit);
    if (unlike) finding = std::move(*unlike);
  }

  result.findings.push_back(std::move(finding));
}

}  // namespace

Finding geometry_mismatch(const GeometryEvidence& geometry, std::string_view measured) {
  return symptom(
      FindingKind::geometry_mismatch,
      fmt::format("{} and scanner do not fit together: slope outside {:g} to {:g}, or over "
                  "{:g} % of the points impossible",
                  measured, FitLimits::least_slope, FitLimits::most_slope,
                  100 * FitLimits::most_outside),
      {{"slope of the coordinate", geometry.slope},
       {"share outside the projector's light", geometry.outside},
       {"share without a point", geometry.without_point}});
}

Finding depths_beyond_boards(const GeometryEvidence& geometry) {
  constexpr double limit = FitLimits::most_out_of_range;
  return symptom(
      FindingKind::depths_beyond_boards,
      fmt::format("over {:g} % of the points lie outside the calibrated depths", 100 * limit),
      {{.name = "share", .value = geometry.out_of_range, .limit = limit},
       {"median depth", geometry.median_depth, "mm"}});
}

Cause beyond_the_boards() {
  return {CauseKind::depth_range, "a scene nearer or farther than the calibration boards"};
}

ScanFindings explain(const JudgedScan& scan, const Fit& fit) {
  ScanFindings result;
  if (fit.geometry) result.median_depth = fit.geometry->median_depth;

  // 1. Causes that leave the settings right: changing light, and exposures out of step.
  auto light = changed_light(scan, fit);

  // A single brighter frame may resemble a share of another.
  const bool one_frame = light && light->finding.frames.size() == 1;
  auto mixed = one_frame ? std::nullopt : mixed_frames(scan, fit);

  // 2. A scan that fits may still hide a fault.
  if (fit.all()) {
    result.findings = remaining_faults(scan, fit, std::move(mixed), std::move(light));
    return result;
  }

  // 3. A frame without a pattern explains everything.
  result.findings = dark_frames(scan);

  // 4. Otherwise the symptom and its likeliest cause.
  if (result.findings.empty()) {
    explain_misfit(scan, fit, std::move(mixed), std::move(light), result);
  }

  return result;
}

}  // namespace slipstream
