#include "check/displaced_frames.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <iterator>

#include <fmt/format.h>

#include "base/linear_algebra.h"

namespace slipstream {
namespace {

/// Displacements of all frames, from a part of the pixels.
struct Displacements {
  /// The part of `all` that `others`, displacements by other pixels, explain.
  [[nodiscard]] double explained_by(const Eigen::VectorXd& others) const {
    return others.dot(2 * right - normal * others);
  }

  Eigen::VectorXd moves{};  ///< of each frame to the right, then of each frame down, pixels
  Eigen::MatrixXd normal;   ///< normal * moves = right
  Eigen::VectorXd right;
  double all = 0;  ///< squared residual that neighbours share
};

/// Solves the normal equations. A displacement that all frames have in common is unobservable, and
/// so are those that only a few steps tell apart: they are held at 0.
void solve(Displacements& displaced) {
  constexpr double slightly = 1e-3;
  const Eigen::Index size = displaced.right.size(), count = size / 2;
  const double held = displaced.normal.trace() / static_cast<double>(size);

  Eigen::MatrixXd normal = displaced.normal;
  normal.topLeftCorner(count, count).array() += held;
  normal.bottomRightCorner(count, count).array() += held;
  normal.diagonal().array() += slightly * held;
  displaced.moves = solve_symmetric(normal, displaced.right);
}

/// From every other group, beginning with `first`, 0 or 1.
Displacements displacements(const JudgedScan& scan, std::size_t first) {
  using Place = ScanSamples::Place;
  constexpr std::array square{Place::middle, Place::right, Place::below, Place::right_below};

  const FrameModel& model = scan.model;
  const auto count = static_cast<Eigen::Index>(model.layout().frames);
  const auto rows = static_cast<Eigen::Index>(model.unexplained_count());
  Displacements found{.normal = Eigen::MatrixXd::Zero(2 * count, 2 * count),
                      .right = Eigen::VectorXd::Zero(2 * count)};

  SampleReading reading;
  Eigen::MatrixX4d left(rows, 4), levels(count, 4);
  Eigen::MatrixXd by_moves(rows, 2 * count);
  for (std::size_t g = first; g < scan.samples.groups(); g += 2) {
    if (!std::ranges::all_of(square, [&](Place at) { return scan.samples.lit(g, at); })) continue;

    for (int i = 0; i < std::ssize(square); ++i) {
      const float* const I = scan.samples.levels(g, square[i]);
      model.read(I, model.identity(), reading);
      left.col(i) = Eigen::Map<const Eigen::VectorXd>(reading.unexplained.data(), rows);
      levels.col(i) = Eigen::Map<const Eigen::VectorXf>(I, count).cast<double>();
    }

    // The frames' slopes share no noise with the mean of the four pixels.
    const Eigen::VectorXd across =
        (levels.col(1) + levels.col(3) - levels.col(0) - levels.col(2)) / 2;
    const Eigen::VectorXd down =
        (levels.col(2) + levels.col(3) - levels.col(0) - levels.col(1)) / 2;

    // A frame that moves by d pixels loses d times its slope.
    by_moves.leftCols(count) = -model.unexplained_of(across.asDiagonal());
    by_moves.rightCols(count) = -model.unexplained_of(down.asDiagonal());

    found.normal += by_moves.transpose() * by_moves;
    found.right += by_moves.transpose() * left.rowwise().mean();
    found.all += (left.col(0).dot(left.col(3)) + left.col(1).dot(left.col(2))) / 2;
  }

  solve(found);
  return found;
}

}  // namespace

std::optional<Finding> displaced_frames(const JudgedScan& scan, const Fit& fit) {
  // Displacements explain nearly the whole residual of motion, and 0.4 of other faults' at most.
  constexpr double least_residual = 0.01, least_explained = 0.6;
  constexpr double least_moved = 0.2;  // pixels

  if (scan.settings.moving || fit.frames.residual < least_residual) return std::nullopt;
  if (scan.model.unexplained_count() == 0) return std::nullopt;

  // Noise may look like motion: displacements by one half of the pixels must explain the other.
  const Displacements one = displacements(scan, 0), other = displacements(scan, 1);
  const double all = one.all + other.all;
  const double explained = one.explained_by(other.moves) + other.explained_by(one.moves);
  if (!(all > 0 && explained >= least_explained * all)) return std::nullopt;

  const Eigen::VectorXd moves = (one.moves + other.moves) / 2;
  const Eigen::Index count = moves.size() / 2;
  const double error =
      (one.moves - other.moves).norm() / (2 * std::sqrt(static_cast<double>(moves.size())));
  const double largest = std::sqrt(
      (moves.head(count).array().square() + moves.tail(count).array().square()).maxCoeff());
  if (largest < least_moved || largest < 4 * error) return std::nullopt;

  Finding finding{
      .kind = FindingKind::pattern_mismatch,
      .severity =
          fit.frames.residual > FitLimits::hopeless_residual ? Severity::wrong : Severity::doubtful,
      .what =
          fmt::format("frames are displaced against each other by over {:g} pixels", least_moved),
      .evidence = {{"displacement", largest, "pixels", least_moved},
                   {"unexplained share of the variation", fit.frames.residual}},
      .causes = {{CauseKind::unclear,
                  "camera, projector or object moved between the frames, or shook"}},
      .remedies = {{"capture the scan again, and hold camera, projector and object still"},
                   {"if the object must move, use pmp or pcmp with extra frames for `motion`, and "
                    "not `fuse`"}}};

  // With periodic stripes, frames that were mixed up may look displaced too.
  if (!fit.patterns_made()) {
    finding.causes.push_back({CauseKind::frame_order, "frames in another order than projected"});
  }
  return finding;
}

}  // namespace slipstream
