#include "slipstream/check/explanations.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Cholesky>
#include <fmt/format.h>

namespace slipstream {
namespace {

std::vector<Evidence> relation_evidence(const FrameEvidence& frames) {
  const auto worst = std::min_element(
      frames.relations.begin(), frames.relations.end(), [](const auto& a, const auto& b) {
        return a.agreement - std::abs(a.offset) < b.agreement - std::abs(b.offset);
      });
  if (worst == frames.relations.end()) return {};
  return {{"agreement", worst->agreement}, {"offset in periods", worst->offset}};
}

/// What of it does not fit, the clearest first.
Finding seen(const Fit& fit) {
  Finding finding{.gravity = Gravity::wrong};
  const auto& geometry = fit.geometry;
  if (!fit.patterns_made()) {
    finding.what = "the frames are not what these patterns make";
    finding.evidence = {{"left over, share of their variation", fit.frames.residual}};
  } else if (!fit.bands_alike()) {
    finding.what = "the bands are lit unlike each other from pixel to pixel";
    finding.evidence = {{"spread of their modulations' ratio", fit.frames.ratio_spread}};
  } else if (!fit.bands_agree()) {
    finding.what = "the frames disagree about the fringe order";
    finding.evidence = relation_evidence(fit.frames);
  } else if (!fit.no_seam()) {
    finding.what = "the coordinate leaps from one end of the field to the other in the light";
    finding.evidence = {{"share of the pixels near it", fit.frames.seams}};
  } else if (!fit.geometry_fits()) {
    finding.what = "frames and scanner do not fit together";
    finding.evidence = {{"slope of the coordinate", geometry->slope},
                        {"share outside the projector's light", geometry->outside},
                        {"share without a point", geometry->without_point}};
  } else {
    finding.what = "most points lie outside of the depths that were calibrated";
    finding.evidence = {{"share", geometry->out_of_range},
                        {"median depth, mm", geometry->median_depth}};
  }
  return finding;
}

/// Where no usual mistake explains it.
void name_broadly(const Fit& fit, Finding& finding) {
  const auto& geometry = fit.geometry;
  // So few pixels are right then that none can be told from the wrong ones.
  constexpr double hopeless_agreement = 0.35, hopeless_offset = 0.25, hopeless_residual = 0.2;
  constexpr double hopeless_outside = 0.6;
  finding.gravity = Gravity::doubtful;
  if (!fit.patterns_made() || !fit.bands_agree() || !fit.no_seam()) {
    const auto hopeless = [](const BandRelation& relation) {
      return relation.agreement < hopeless_agreement || std::abs(relation.offset) > hopeless_offset;
    };
    const auto& relations = fit.frames.relations;
    if (fit.frames.residual > hopeless_residual ||
        std::any_of(relations.begin(), relations.end(), hopeless)) {
      finding.gravity = Gravity::wrong;
    }
    finding.likely = "other patterns than said, frames lost or mixed up, or something moved";
    finding.advice = "compare the pictures with those of slipstream patterns";
  } else if (!fit.geometry_fits()) {
    if (geometry->outside + geometry->without_point > hopeless_outside)
      finding.gravity = Gravity::wrong;
    finding.likely =
        "a scanner file of another rig, pictures cropped or of another size, or a camera or "
        "projector that moved since the calibration";
    finding.advice = "check the file, and calibrate again where the rig was touched";
  } else {
    finding.likely =
        "something nearer or farther than the boards were, or a scanner file of another rig";
    finding.advice = "calibrate with boards at those depths, or check the order of the frames";
  }
}

/// How much brighter each frame is than the others, as a share, from what patterns of that shape
/// cannot make; their mean is 0.
struct FrameGains {
  Eigen::VectorXd gains;
  double explained = 0;  ///< the share of the residual that they account for
  struct OddFrame {
    int frame = 0;
    double gain = 0;
  };
  /// The one whose gain alone accounts for nearly all, and for more than any other's does.
  std::optional<OddFrame> odd_frame{};
};

/// Of equations normal * gains = right, whose residual is `all`: what each gain accounts for alone.
std::optional<FrameGains::OddFrame> odd_frame(const Eigen::MatrixXd& normal,
                                              const Eigen::VectorXd& right, double all) {
  constexpr double least_share = 0.7, least_lead = 0.1;
  std::optional<FrameGains::OddFrame> best;
  double most = 0, second = 0;
  for (Eigen::Index n = 0; n < right.size(); ++n) {
    const double share = normal(n, n) > 0 && all > 0 ? right[n] * right[n] / normal(n, n) / all : 0;
    second = std::max(second, std::min(share, most));
    if (share <= most) continue;
    most = share;
    best = {static_cast<int>(n), right[n] / normal(n, n)};
  }
  return most >= least_share && most >= second + least_lead ? best : std::nullopt;
}

FrameGains frame_gains(const FrameModel& model, const ScanSamples& samples) {
  const int count = model.layout().frames;
  // Gains leave P diag(I) gain where P I of the true frames is nothing; both sides of a product are
  // of different neighbours, which share no noise.
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
  for (std::size_t g = 0; g < samples.groups(); ++g) {
    if (!samples.lit(g, ScanSamples::right)) continue;
    by_gains(samples.levels(g, ScanSamples::middle), changes_a, left_a);
    by_gains(samples.levels(g, ScanSamples::right), changes_b, left_b);
    normal += changes_a.transpose() * changes_b + changes_b.transpose() * changes_a;
    right += changes_a.transpose() * left_b + changes_b.transpose() * left_a;
    all += 2 * left_a.dot(left_b);
  }
  // All frames brighter alike are nothing to be seen: the mean is held at 0.
  const double held = normal.trace() / count;
  const Eigen::VectorXd gains =
      (normal + Eigen::MatrixXd::Constant(count, count, held)).ldlt().solve(right);
  return {gains, all > 0 ? gains.dot(right) / all : 0, odd_frame(normal, right, all)};
}

/// Light that changed between frames.
std::optional<Finding> flicker(const JudgedScan& scan, const Fit& fit) {
  // Right scans leave more at times, a real skull 0.0085, but then no gains explain it: at most
  // 0.62 of it, and by half a percent. Lamps and exposures do not change by more than the last.
  constexpr double least_residual = 0.003, least_explained = 0.7, least_gain = 0.025;
  constexpr double most_gain = 0.3;
  if (fit.frames.residual < least_residual) return std::nullopt;
  const FrameGains gains = frame_gains(scan.model, scan.samples);
  const double size = gains.gains.cwiseAbs().maxCoeff();
  if (!(gains.explained >= least_explained && size >= least_gain && size <= most_gain)) {
    return std::nullopt;
  }
  // Motion may look like light, but hardly like that of one frame alone.
  if (scan.settings.moving && !gains.odd_frame) return std::nullopt;
  const auto& odd = gains.odd_frame;
  return Finding{
      .what = "frames are brighter or darker than the patterns make them",
      .evidence = {odd ? Evidence{fmt::format("frame {}, percent", odd->frame), 100 * odd->gain}
                       : Evidence{"the most, percent", 100 * size}},
      .likely = "light that flickers, or an exposure or gain that changed between frames",
      .advice =
          "fix exposure and gain, and expose for whole periods of the mains and the projector"};
}

/// Frames without any pattern, where they are no dark part of one.
std::vector<Finding> dark_frames(const JudgedScan& scan, const Fit& fit) {
  // Frames that contradict each other so much have lost one; where they cannot, what the scene sees
  // of the patterns must make it bright somewhere.
  constexpr double contradicting = 0.2, least_of_pattern = 0.5;
  if (scan.model.unexplained_count() > 0 && fit.frames.residual < contradicting) return {};
  if (!scan.model.has_redundancy()) {
    for (int n = 0; n < scan.samples.frames(); ++n) {
      if (scan.model.shown_range(n, scan.samples) < least_of_pattern) return {};
    }
  }
  return frames_without_pattern(scan.samples);
}

}  // namespace

ScanFindings explain(const JudgedScan& scan) {
  if (scan.samples.groups() < ScanSamples::fewest_groups) return {};
  ScanFindings result;
  const Fit fit = fit_as_given(scan);
  auto flickering = flicker(scan, fit);
  if (fit.all()) {
    // Where frames say something of each other a dark one would not have fitted.
    if (!scan.model.has_redundancy()) result.findings = dark_frames(scan, fit);
    if (flickering && result.findings.empty()) result.findings.push_back(std::move(*flickering));
    return result;
  }
  Finding finding = seen(fit);
  const bool only_depths =
      fit.bands_agree() && fit.patterns_made() && fit.no_seam() && fit.geometry_fits();
  if (auto explanation = likeliest_mistake(scan, fit)) {
    if (only_depths) {
      // The scene may be where no board was, as well.
      explanation->gravity = Gravity::doubtful;
      explanation->likely += ", or something nearer or farther than the boards were";
    }
    finding.likely = std::move(explanation->likely);
    finding.advice = std::move(explanation->advice);
    finding.gravity = explanation->gravity;
    result.order = std::move(explanation->order);
  } else if (std::vector<Finding> faults = dark_frames(scan, fit); !faults.empty()) {
    result.findings = std::move(faults);
    return result;
  } else if (flickering) {
    finding = std::move(*flickering);
  } else {
    name_broadly(fit, finding);
  }
  result.findings.push_back(std::move(finding));
  return result;
}

}  // namespace slipstream
