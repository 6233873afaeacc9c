#include "check/explanations.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <Eigen/Cholesky>
#include <fmt/format.h>

#include "base/statistics.h"
#include "check/code_evidence.h"
#include "check/frame_faults.h"
#include "check/method_limits.h"
#include "check/mistake_search.h"
#include "check/out_of_step.h"

namespace slipstream {
namespace {

const Cause beyond_the_boards{CauseKind::depth_range,
                              "a scene nearer or farther than the calibration boards"};

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
      {{.name = "left over, share of their variation",
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

Finding fringe_orders_disagree(const FrameEvidence& frames) {
  Finding finding = symptom(
      FindingKind::fringe_orders_disagree,
      fmt::format(
          "the frames disagree about the fringe order: agreement below {:g} or offset above {:g}",
          FitLimits::least_agreement, FitLimits::most_offset),
      {});

  const auto worst = std::ranges::min_element(frames.relations, [](const auto& a, const auto& b) {
    return a.agreement - std::abs(a.offset) < b.agreement - std::abs(b.offset);
  });

  if (worst != frames.relations.end()) {
    finding.evidence = {
        {.name = "agreement", .value = worst->agreement, .limit = FitLimits::least_agreement},
        {.name = "offset in periods", .value = worst->offset, .limit = FitLimits::most_offset}};
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

Finding geometry_mismatch(const GeometryEvidence& geometry) {
  return symptom(
      FindingKind::geometry_mismatch,
      fmt::format("frames and scanner do not fit together: slope outside {:g} to {:g}, or over "
                  "{:g} % of the points impossible",
                  FitLimits::least_slope, FitLimits::most_slope, 100 * FitLimits::most_outside),
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

/// The clearest symptom of a scan that does not fit: of the first test that fails, the most basic
/// one first.
Finding seen(const Fit& fit) {
  if (!fit.patterns_made()) return pattern_mismatch(fit);
  if (!fit.code_agrees()) return contradicting_code(fit.code);
  if (!fit.bands_alike()) return unrelated_modulations(fit.frames);
  if (!fit.bands_agree()) return fringe_orders_disagree(fit.frames);
  if (!fit.no_seam()) return coordinate_jumps(fit.frames);
  if (!fit.geometry_fits()) return geometry_mismatch(*fit.geometry);
  return depths_beyond_boards(*fit.geometry);
}

/// Names a broad cause if no common mistake explains the misfit.
void name_broadly(const Fit& fit, bool response_known, Finding& finding) {
  const auto& geometry = fit.geometry;
  // Beyond these, too few pixels are right to separate them from wrong ones.
  constexpr double hopeless_agreement = 0.35, hopeless_offset = 0.25, hopeless_residual = 0.15;
  constexpr double hopeless_outside = 0.6;

  const auto blame = [&](CauseKind kind, std::string_view text) {
    finding.causes.push_back({kind, std::string(text)});
  };
  const auto blame_gamma = [&] {
    if (!response_known) blame(CauseKind::gamma, "the projector's gamma, if it is not 1");
  };

  finding.severity = Severity::doubtful;
  if (fit.patterns_made() && !fit.code_agrees()) {
    const CodeSymptom& worst = worst_symptom(fit.code);
    if (std::abs(fit.code.*worst.value) > 2 * worst.limit) finding.severity = Severity::wrong;

    blame(worst.cause, worst.likely);
    if (worst.value == &CodeEvidence::doubt) blame_gamma();
    finding.remedies = {{fmt::format("{} the output of `patterns()`", worst.compare)}};
  } else if (fit.frames.damping > 0) {
    finding.evidence.push_back(
        {"fringes fainter than the cue by", 100 * fit.frames.damping, "percent"});
    blame(CauseKind::blur,
          "fringes blurred by a lens or by too few pixels per period: fringe orders at the ends of "
          "the field are wrong");
    finding.remedies = {{"focus both lenses, use larger pictures or fewer periods (`high`)"}};
  } else if (!fit.frames_fit()) {
    const auto hopeless = [](const BandRelation& relation) {
      return relation.agreement < hopeless_agreement || std::abs(relation.offset) > hopeless_offset;
    };
    const auto& relations = fit.frames.relations;
    if (fit.frames.residual > hopeless_residual || std::ranges::any_of(relations, hopeless)) {
      finding.severity = Severity::wrong;
    }

    blame(CauseKind::unclear,
          "wrong pattern settings, lost or mixed-up frames, or motion during capture");
    blame_gamma();
    finding.remedies = {{"compare the frames with the output of `patterns()`"}};
  } else if (!fit.geometry_fits()) {
    if (geometry->outside + geometry->without_point > hopeless_outside)
      finding.severity = Severity::wrong;
    blame(CauseKind::other_rig,
          "a scanner file of another rig, pictures cropped or of another size, or a camera or "
          "projector that moved since calibration");
    finding.remedies = {{"check the scanner file; if the rig moved, run `calibrate_geometry()`"}};
  } else {
    finding.causes = {beyond_the_boards};
    blame(CauseKind::other_rig, "a scanner file of another rig");
    finding.remedies = {{"calibrate with boards at those depths, or check the frame order"}};
  }
}

/// Relative gain of each frame, estimated from the unexplained components; the mean is 0.
struct FrameGains {
  /// The part of `all` that `others`, gains from other pixels, explain.
  [[nodiscard]] double explained_by(const Eigen::VectorXd& others) const {
    return others.dot(2 * right - normal * others);
  }

  Eigen::VectorXd gains;
  Eigen::MatrixXd normal;  ///< normal * gains = right, with residual `all`
  Eigen::VectorXd right;
  double all = 0;
};

/// A frame and its gain, relative to the mean of all.
struct FrameGain {
  int frame = 0;
  double gain = 0;
};

/// The frame whose gain alone explains nearly all, and more than any other's.
std::optional<FrameGain> odd_frame(const FrameGains& gains) {
  constexpr double least_share = 0.7, least_lead = 0.1;
  const auto& [unused, normal, right, all] = gains;
  std::optional<FrameGain> best;

  double most = 0, second = 0;
  for (Eigen::Index n = 0; n < right.size(); ++n) {
    // Part of the residual that the gain of frame n alone explains by least squares.
    const double share = normal(n, n) > 0 && all > 0 ? right[n] * right[n] / normal(n, n) / all : 0;
    second = std::max(second, std::min(share, most));
    if (share <= most) continue;
    most = share;
    best = FrameGain{static_cast<int>(n), right[n] / normal(n, n)};
  }

  // The clearest frame must stand out from the second.
  return most >= least_share && most >= second + least_lead ? best : std::nullopt;
}

/// The gains from every other group, from `first` (0 or 1) on.
FrameGains frame_gains(const FrameModel& model, const ScanSamples& samples, std::size_t first) {
  const int count = model.layout().frames;

  // P I is 0 for true frames, so gains leave P diag(I) gain. Both factors of each product come from
  // different neighbours, which share no noise.
  const FrameOrder order = model.identity();
  Eigen::MatrixXd normal = Eigen::MatrixXd::Zero(count, count);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(count);
  double all = 0;

  SampleReading reading;
  const auto rows = static_cast<Eigen::Index>(model.unexplained_count());
  const auto by_gains = [&](const float* levels, Eigen::MatrixXd& changes, Eigen::VectorXd& left) {
    model.read(levels, order, reading);
    left = Eigen::Map<const Eigen::VectorXd>(reading.unexplained.data(), rows);
    for (int n = 0; n < count; ++n) changes.col(n) = model.unexplained_by(n, levels[n]);
  };

  Eigen::MatrixXd changes_a(rows, count), changes_b(rows, count);
  Eigen::VectorXd left_a(rows), left_b(rows);

  // Normal equations, each pair of neighbours used both ways round.
  for (std::size_t g = first; g < samples.groups(); g += 2) {
    if (!samples.lit(g, ScanSamples::right)) continue;

    by_gains(samples.levels(g, ScanSamples::middle), changes_a, left_a);
    by_gains(samples.levels(g, ScanSamples::right), changes_b, left_b);
    normal += changes_a.transpose() * changes_b + changes_b.transpose() * changes_a;
    right += changes_a.transpose() * left_b + changes_b.transpose() * left_a;
    all += 2 * left_a.dot(left_b);
  }

  // A common gain is unobservable: fix the mean at 0.
  const double held = normal.trace() / count;
  const Eigen::VectorXd gains =
      (normal + Eigen::MatrixXd::Constant(count, count, held)).ldlt().solve(right);

  return {gains, normal, right, all};
}

/// Detects light that changed between frames.
std::optional<Finding> flicker(const JudgedScan& scan, const Fit& fit) {
  // Correct scans sometimes leave more (a real skull: 0.0085), but gains explain at most 0.62 of
  // it, at half a percent. Lamps and exposures do not change by more than most_gain.
  constexpr double least_residual = 0.003, least_explained = 0.7, least_gain = 0.025;
  constexpr double most_gain = 0.3;
  if (fit.frames.residual < least_residual) return std::nullopt;

  // Noise may look like gains: those of one half of the pixels must explain the other half.
  const FrameGains gains = frame_gains(scan.model, scan.samples, 0);
  const FrameGains others = frame_gains(scan.model, scan.samples, 1);

  // The largest gain, its standard error from the two halves, and the share they explain.
  const double size = (gains.gains + others.gains).cwiseAbs().maxCoeff() / 2;
  const double error = (gains.gains - others.gains).norm() / (2 * std::sqrt(gains.gains.size()));
  const double explained = (gains.explained_by(others.gains) + others.explained_by(gains.gains)) /
                           (gains.all + others.all);
  if (!(explained >= least_explained && size >= least_gain && size <= most_gain &&
        size >= 4 * error)) {
    return std::nullopt;
  }

  const auto odd = odd_frame(gains);
  // Motion may resemble flicker, but rarely of a single frame.
  if (scan.settings.moving && !odd) return std::nullopt;

  Finding finding{
      .kind = FindingKind::changing_light,
      .what = fmt::format("frames are over {:g} % brighter or darker than the patterns",
                          100 * least_gain),
      .evidence = {{"the most", 100 * size, "percent", 100 * least_gain}},
      .causes = {{CauseKind::flicker,
                  "light that flickers, or an exposure or gain that changed between frames"}},
      .remedies = {
          {"fix exposure and gain; expose for whole periods of the mains and the projector"}}};

  if (odd) {
    finding.frames = {odd->frame};
    finding.evidence = {
        {fmt::format("frame {}", odd->frame), 100 * odd->gain, "percent", 100 * least_gain}};
  }

  return finding;
}

/// Frames that vary over a scene only if frame n does: those of its bands; of a code the next
/// coarser bit, or the bit that an inverse inverts. nullopt for a uniform pattern.
std::optional<std::vector<int>> frames_beside(const Layout& layout, int n) {
  std::vector<int> beside;
  bool varies = false;

  // The other frames of the bands that frame n belongs to.
  for (const Band& band : layout.bands) {
    const auto is_in = [&](int m) {
      return !layout.unwrapping->whole_stripes && (band.cosine[m] != 0 || band.sine[m] != 0);
    };

    if (!is_in(n)) continue;
    varies = true;
    for (int m = 0; m < layout.frames; ++m) {
      if (m != n && is_in(m)) beside.push_back(m);
    }
  }

  // In a code: the bit that an inverse inverts, or the next coarser bit.
  if (!layout.code) return beside;
  const std::vector<int>&bits = layout.code->frames, &inverses = layout.code->inverses;
  const auto bit = std::ranges::find(bits, n), inverse = std::ranges::find(inverses, n);

  // Frames with a common base all share its edges, so that their coarser bits prove little.
  if (inverse != inverses.end()) {
    beside.push_back(bits[inverse - inverses.begin()]);
  } else if (bit != bits.end() && bit != bits.begin() && !layout.code->base) {
    beside.push_back(*std::prev(bit));
  }

  varies |= bit != bits.end() || inverse != inverses.end();
  return varies ? std::optional(beside) : std::nullopt;
}

/// How much of a pixel's range a frame covers over the lit pixels, 0 to 1.
double shown_range(const ScanSamples& samples, int n) {
  std::vector<double> shares;

  for (std::size_t g = 0; g < samples.groups(); ++g) {
    const float* const levels = samples.levels(g, ScanSamples::middle);
    const auto [least, greatest] = std::minmax_element(levels, levels + samples.frames());
    shares.push_back((levels[n] - *least) / std::max(1.0F, *greatest - *least));
  }

  // Without the outliers at either end.
  const double most = quantile(shares, 0.95);
  return most - quantile(shares, 0.05);
}

/// Finds frames without any pattern, unless the scene lies in a dark part of it: if no frame is
/// lost, another frame must show that the scene reaches a bright part.
std::vector<Finding> dark_frames(const JudgedScan& scan, bool lost = false) {
  constexpr double least_shown = 0.7;
  const auto is_shown = [&](int n) { return shown_range(scan.samples, n) >= least_shown; };

  std::vector<Finding> findings;
  for (int n = 0; n < scan.samples.frames(); ++n) {
    auto finding = without_pattern(scan.samples, n);
    if (!finding) continue;

    // If no other frame is bright, the scene may lie in the dark part of the pattern.
    const auto beside = frames_beside(scan.model.layout(), n);
    const bool reached = beside && (lost || std::ranges::any_of(*beside, is_shown));
    if (reached) findings.push_back(std::move(*finding));
  }

  return findings;
}

/// Of a scan that fits: another mistake that explains it far better.
std::optional<Finding> better_fit(const JudgedScan& scan, const Fit& fit) {
  constexpr double clearly = 0.5;
  auto better = fit.poor() ? likeliest_mistake(scan, fit) : std::nullopt;
  if (!better) return std::nullopt;

  // Depths beyond the boards may be the scene's own: on their own they prove no mistake.
  const double beyond = fit.geometry ? fit.geometry->beyond : 0;
  const bool by_depths_alone = fit.misfit() - beyond < better->misfit + clearly;

  Finding finding{.kind = FindingKind::better_settings,
                  .severity = by_depths_alone ? Severity::doubtful : Severity::wrong,
                  .what = "the scan would fit far better with other settings",
                  .evidence = {{"misfit", fit.misfit()}, {"misfit then", better->misfit}},
                  .causes = std::move(better->causes),
                  .remedies = std::move(better->remedies),
                  .remark = std::move(better->remark)};

  if (by_depths_alone) finding.causes.push_back(beyond_the_boards);
  if (fit.geometry) finding.evidence.push_back({"median depth", fit.geometry->median_depth, "mm"});

  return finding;
}

/// Of a scan that fits.
std::vector<Finding> remaining_faults(const JudgedScan& scan, const Fit& fit,
                                      std::optional<MixedFrames> mixed,
                                      std::optional<Finding> flickering) {
  if (mixed) return {std::move(mixed->finding)};

  // With redundancy, a dark frame would not have fitted.
  if (!scan.model.has_redundancy()) {
    if (std::vector<Finding> dark = dark_frames(scan); !dark.empty()) return dark;
  }

  // Then the mistakes that are harder to see, and last the limits of the method.
  if (flickering) return {std::move(*flickering)};
  if (auto better = better_fit(scan, fit)) return {std::move(*better)};
  return method_limits(scan, fit);
}

}  // namespace

namespace {

/// Two explanations whose misfits differ by less explain a scan about as well.
constexpr double nearly = 0.3;

/// Takes over the likeliest mistake, and names others that explain the scan about as well: frames
/// that contain a share of another, and dark ones.
void name_mistake(Explanation explanation, bool only_depths,
                  const std::optional<MixedFrames>& mixed, std::vector<Finding> dark,
                  ScanFindings& result, Finding& finding) {
  if (only_depths) {
    explanation.severity = Severity::doubtful;
    explanation.causes.push_back(beyond_the_boards);
  }

  finding.causes = std::move(explanation.causes);
  finding.remedies = std::move(explanation.remedies);
  finding.remark = std::move(explanation.remark);
  finding.severity = explanation.severity;

  // Set if the cycle has slipped: the caller then reorders the frames.
  result.order = std::move(explanation.order);
  if (!result.order.empty()) result.median_depth = explanation.median_depth;

  if (mixed && mixed->misfit < explanation.misfit + nearly) dark.push_back(mixed->finding);
  for (const Finding& fault : dark) {
    std::ranges::copy(fault.causes, std::back_inserter(finding.causes));
  }
}

/// Of a scan that does not fit: its symptom, and the likeliest cause, or a broad one if no specific
/// one explains it.
void explain_misfit(const JudgedScan& scan, const Fit& fit, std::optional<MixedFrames> mixed,
                    std::optional<Finding> flickering, ScanFindings& result) {
  Finding finding = seen(fit);
  const bool only_depths = fit.frames_fit() && fit.geometry_fits();
  const bool response_known = scan.photometry.response.has_value();

  // 1. Common mistakes; a doubtful scanner explains a misfit of the geometry already.
  if (scan.scanner_doubted && fit.frames_fit()) {
    name_broadly(fit, response_known, finding);
    if (!only_depths) finding.severity = Severity::wrong;
    result.findings.push_back(std::move(finding));
    return;
  }

  auto explanation = likeliest_mistake(scan, fit);

  // 2. Frames without a pattern.
  constexpr double contradicting = 0.2;  // so far off that a frame may be lost
  const bool is_lost = !fit.code_agrees() ||
                       (scan.model.unexplained_count() > 0 && fit.frames.residual >= contradicting);
  std::vector<Finding> dark = dark_frames(scan, is_lost);

  // 3. The likeliest of all.
  if (mixed && dark.empty() && (!explanation || mixed->misfit < explanation->misfit - nearly)) {
    finding = std::move(mixed->finding);
  } else if (explanation) {
    name_mistake(*std::move(explanation), only_depths, mixed, std::move(dark), result, finding);
  } else if (!dark.empty()) {
    result.findings = std::move(dark);
    return;
  } else if (flickering) {
    finding = std::move(*flickering);
  } else {
    name_broadly(fit, response_known, finding);
  }

  result.findings.push_back(std::move(finding));
}

}  // namespace

ScanFindings explain(const JudgedScan& scan, const Fit& fit) {
  ScanFindings result;
  if (fit.geometry) result.median_depth = fit.geometry->median_depth;

  // 1. Causes that leave the settings right: changing light, and exposures out of step.
  auto flickering = flicker(scan, fit);

  // A single brighter frame may resemble a share of another.
  const bool one_frame = flickering && !flickering->frames.empty();
  auto mixed = one_frame ? std::nullopt : mixed_frames(scan, fit);

  // 2. A scan that fits may still hide a fault.
  if (fit.all()) {
    result.findings = remaining_faults(scan, fit, std::move(mixed), std::move(flickering));
    return result;
  }

  // 3. A frame without a pattern explains everything.
  result.findings = dark_frames(scan);

  // 4. Otherwise the symptom and its likeliest cause.
  if (result.findings.empty()) {
    explain_misfit(scan, fit, std::move(mixed), std::move(flickering), result);
  }

  return result;
}

}  // namespace slipstream
