#include "check/contradicting_frame.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <fmt/ranges.h>

namespace slipstream {
namespace {

/// The direction of each frame's residual as a unit vector; 0 for frames that the patterns never
/// contradict.
std::vector<Eigen::VectorXd> directions_of(const FrameModel& model) {
  constexpr double least = 1e-6;

  std::vector<Eigen::VectorXd> directions;
  for (int n = 0; n < model.layout().frames; ++n) {
    Eigen::VectorXd direction = model.unexplained_by(n, 1);
    const double length = direction.norm();
    directions.emplace_back(length > least ? Eigen::VectorXd(direction / length)
                                           : Eigen::VectorXd(0 * direction));
  }
  return directions;
}

/// The share of the residual that any change of each frame alone explains. Neighbours share no
/// noise.
std::vector<double> explained_shares(const JudgedScan& scan,
                                     const std::vector<Eigen::VectorXd>& directions) {
  std::vector<double> shares(directions.size());
  double all = 0;

  SampleReading here, next;
  const auto rows = static_cast<Eigen::Index>(scan.model.unexplained_count());
  for (std::size_t g = 0; g < scan.samples.groups(); ++g) {
    if (!scan.samples.lit(g, ScanSamples::right)) continue;

    const FrameOrder order = scan.model.identity();
    scan.model.read(scan.samples.levels(g, ScanSamples::middle), order, here);
    scan.model.read(scan.samples.levels(g, ScanSamples::right), order, next);

    const Eigen::Map<const Eigen::VectorXd> left(here.unexplained.data(), rows);
    const Eigen::Map<const Eigen::VectorXd> beside(next.unexplained.data(), rows);
    all += left.dot(beside);
    for (std::size_t n = 0; n < shares.size(); ++n) {
      shares[n] += left.dot(directions[n]) * beside.dot(directions[n]);
    }
  }

  for (double& share : shares) share = all > 0 ? share / all : 0;
  return shares;
}

/// Correct scans leave 0.014, real ones of twelve steps 0.07 by no single frame.
constexpr double least_residual = 0.02;

/// `which`: the frames in words; `frames`: their numbers, if they are known.
Finding finding_about(const std::string& which, std::vector<int> frames, double residual) {
  return {
      .kind = FindingKind::pattern_mismatch,
      .severity = residual > FitLimits::hopeless_residual ? Severity::wrong : Severity::doubtful,
      .what = fmt::format("{}: over {:g} % of the frames' variation is unexplained", which,
                          100 * least_residual),
      .evidence = {{.name = "unexplained share of the variation",
                    .value = residual,
                    .limit = least_residual}},
      .causes = {{CauseKind::unclear, "a frame out of focus, shaken, or lit by other light"}},
      .remedies = {{"capture the scan again; hold camera, projector and object still, and "
                    "switch off automatic focus"}},
      .frames = std::move(frames)};
}

}  // namespace

std::optional<Finding> contradicting_frame(const JudgedScan& scan, const Fit& fit) {
  constexpr double least_share = 0.9, most_of_others = 0.8;
  constexpr double alike = 0.99;  // cosine of the angle between two frames' directions

  const double residual = fit.frames.residual;
  if (scan.settings.moving || residual < least_residual || scan.model.unexplained_count() < 2) {
    return std::nullopt;
  }

  // 1. The frame that explains the residual best.
  const std::vector<Eigen::VectorXd> directions = directions_of(scan.model);
  const std::vector<double> shares = explained_shares(scan, directions);
  const auto best = std::ranges::max_element(shares) - shares.begin();
  if (shares[best] < least_share) return std::nullopt;

  // 2. Those that the patterns cannot tell from it; all others must explain clearly less.
  std::vector<int> frames;
  for (std::size_t n = 0; n < shares.size(); ++n) {
    if (std::abs(directions[n].dot(directions[best])) > alike) {
      frames.push_back(static_cast<int>(n));
    } else if (shares[n] > most_of_others) {
      return std::nullopt;
    }
  }

  if (2 * frames.size() > shares.size()) return std::nullopt;
  const std::string which = frames.size() == 1
                                ? fmt::format("frame {}", frames.front())
                                : fmt::format("one of the frames {}", fmt::join(frames, ", "));
  return finding_about(which + " contradicts the others", frames, residual);
}

std::optional<Finding> contradicting_frames(const JudgedScan& scan, const Fit& fit) {
  const Layout& layout = scan.model.layout();
  if (fit.frames.residual < least_residual || layout.code || layout.bands.size() > 1) {
    return std::nullopt;
  }

  // Blur takes harmonics of any other response away, more of them where surfaces lie out of focus:
  // no one waveform explains up to 0.05 of right scans.
  const auto& known = scan.photometry.response;
  if (!known || !is_linear(known->response)) return std::nullopt;

  const auto waveform = waveform_of(scan.model, scan, scan.model.identity());
  if (!waveform || waveform->residual < least_residual) return std::nullopt;
  return finding_about("frames contradict each other", {}, waveform->residual);
}

}  // namespace slipstream
