#include "check/changing_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <fmt/format.h>

namespace slipstream {
namespace {

/// Relative gain of each frame, estimated from the unexplained components; the mean is 0.
struct FrameGains {
  /// The part of `all` that `others`, gains from other pixels, explain.
  [[nodiscard]] double explained_by(const Eigen::VectorXd& others) const {
    return others.dot(2 * right - normal * others);
  }

  std::vector<int> frames{};  ///< of each gain
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
  const auto& [frames, unused, normal, right, all] = gains;
  std::optional<FrameGain> best;

  double most = 0, second = 0;
  for (Eigen::Index n = 0; n < right.size(); ++n) {
    // Part of the residual that the gain of frame n alone explains by least squares.
    const double share = normal(n, n) > 0 && all > 0 ? right[n] * right[n] / normal(n, n) / all : 0;
    second = std::max(second, std::min(share, most));
    if (share <= most) continue;
    most = share;
    best = FrameGain{frames[n], right[n] / normal(n, n)};
  }

  // The clearest frame must stand out from the second.
  return most >= least_share && most >= second + least_lead ? best : std::nullopt;
}

/// The frames that an unexplained component contains: not a code's whose bits are all there is.
std::vector<int> compared_frames(const FrameModel& model) {
  constexpr double least = 1e-6;

  std::vector<int> frames;
  for (int n = 0; n < model.layout().frames; ++n) {
    if (model.unexplained_by(n, 1).norm() > least) frames.push_back(n);
  }
  return frames;
}

/// The gains from every other group, from `first` (0 or 1) on.
FrameGains frame_gains(const FrameModel& model, const ScanSamples& samples, std::size_t first) {
  const std::vector<int> frames = compared_frames(model);
  const auto count = static_cast<Eigen::Index>(frames.size());

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
    for (Eigen::Index i = 0; i < count; ++i) {
      changes.col(i) = model.unexplained_by(frames[i], levels[frames[i]]);
    }
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
  const double held = normal.trace() / static_cast<double>(count);
  const Eigen::VectorXd gains =
      (normal + Eigen::MatrixXd::Constant(count, count, held)).ldlt().solve(right);

  return {frames, gains, normal, right, all};
}

/// Whether the frames of a code have one gain, and the others another, as if the response were not
/// linear: a code shows black and white, the others what is between.
bool parts_code(const FrameGains& gains, const std::optional<Code>& code) {
  constexpr double most_within = 0.2;  // share of the gains' sum of squares
  if (!code) return false;

  std::array<double, 2> count{}, sum{}, squares{};
  for (std::size_t i = 0; i < gains.frames.size(); ++i) {
    const int n = gains.frames[i];
    const double gain = gains.gains[static_cast<Eigen::Index>(i)];
    const bool in_code =
        std::ranges::count(code->frames, n) > 0 || std::ranges::count(code->inverses, n) > 0;

    const std::size_t kind = in_code ? 1 : 0;
    count[kind] += 1;
    sum[kind] += gain;
    squares[kind] += gain * gain;
  }
  if (count[0] == 0 || count[1] == 0) return false;

  // Sums of squares about the mean of each kind, and about the mean of all.
  const double within =
      squares[0] - sum[0] * sum[0] / count[0] + squares[1] - sum[1] * sum[1] / count[1];
  const double in_all =
      squares[0] + squares[1] - std::pow(sum[0] + sum[1], 2) / (count[0] + count[1]);
  return within < most_within * in_all;
}

}  // namespace

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

  if (!scan.photometry.response && parts_code(gains, scan.model.layout().code)) {
    finding.causes.insert(finding.causes.begin(),
                          {CauseKind::gamma, "the projector's gamma, if it is not 1"});
    finding.remedies.insert(finding.remedies.begin(),
                            {"measure the gamma with `calibrate_gamma()`"});
  }

  return finding;
}

}  // namespace slipstream
