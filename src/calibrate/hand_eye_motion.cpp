#include "calibrate/hand_eye_motion.h"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

#include "base/linear_algebra.h"
#include "base/numbers.h"
#include "geometry/rotation.h"

namespace slipstream {
namespace {

using Normal = Eigen::Matrix<double, 12, 12>;

/// The standard deviations of the camera's pose with this information.
MorePoses deviations_with(const Normal& normal, std::string which) {
  const Eigen::Matrix<double, 12, 1> variances = inverse_of(normal).diagonal();
  return {.which = std::move(which),
          .rotation = std::sqrt(variances.head<3>().sum()),
          .translation = std::sqrt(variances.segment<3>(3).sum())};
}

/// The pair with the tool turned about one of its axes, and the board's origin, a corner, where it
/// was.
PosePair turned(const PosePair& pair, const HandEyePoses& poses, EyePlace place, int axis,
                double angle) {
  const Eigen::AngleAxisd turn(angle, Eigen::Vector3d::Unit(axis));
  PosePair other = pair;

  if (place == EyePlace::in_hand) {
    const Eigen::Matrix3d from_tool = poses.camera.linear().transpose();
    other.board.linear() = from_tool * turn * from_tool.transpose() * pair.board.linear();
  } else {
    const Eigen::Matrix3d to_tool = poses.board.linear();
    other.board.linear() = pair.board.linear() * to_tool.transpose() * turn * to_tool;
  }

  other.robot = robot_for(other.board, poses, place);
  return other;
}

}  // namespace

TurnSpread turn_spread(std::span<const PosePair> pairs) {
  // The tool's turns from the first pose, about their mean.
  Eigen::Matrix3Xd turns(3, static_cast<Eigen::Index>(pairs.size()));
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    turns.col(static_cast<Eigen::Index>(i)) =
        vector_of(pairs.front().robot.linear().transpose() * pairs[i].robot.linear());
  }
  turns.colwise() -= Eigen::Vector3d(turns.rowwise().mean());

  const Eigen::Matrix3d squares = turns * turns.transpose() / static_cast<double>(pairs.size());
  const PrincipalAxes axes = principal_axes(squares);
  return {axes.values.cwiseMax(0).cwiseSqrt().reverse(), axes.vectors.rowwise().reverse()};
}

char weakest_axis(const TurnSpread& spread) {
  // The stronger of the two weaker axes is needed; where both are weak, it does not matter which.
  Eigen::Index axis = 0;
  spread.axes.col(1).cwiseAbs().maxCoeff(&axis);
  return "xyz"[axis];
}

std::vector<Finding> findings_of_motion(const TurnSpread& spread) {
  constexpr double enough = 8 * degree;
  if (spread.turns[1] >= enough) return {};

  Finding finding{.kind = FindingKind::parallel_boards,
                  .what = "the tool turned little about a second axis",
                  .evidence = {{"turn about a second axis", spread.turns[1] / degree, "degrees",
                                enough / degree}}};
  finding.causes = {{CauseKind::few_tilts, "poses too similar"}};
  finding.remedies = {
      {fmt::format("add poses turned by 20 degrees or more, both ways, about the tool's {}",
                   weakest_axis(spread))}};
  return {finding};
}

std::vector<MorePoses> more_poses(std::span<const PosePair> pairs, const AdjustedHandEye& fit,
                                  EyePlace place) {
  constexpr double turn = 30 * degree;
  const Normal normal = inverse_of(fit.covariance);
  std::vector<MorePoses> more;
  more.push_back(deviations_with(2 * normal, fmt::format("{} more like these", pairs.size())));

  // The pose in the middle, turned both ways.
  const PosePair& middle = *std::ranges::min_element(pairs, {}, [&](const PosePair& pair) {
    double sum = 0;
    for (const PosePair& other : pairs) {
      sum += angle_between(pair.robot.linear(), other.robot.linear());
    }
    return sum;
  });

  for (int axis = 0; axis < 3; ++axis) {
    Normal with = normal;
    for (const double angle : {-turn, turn}) {
      const PosePair pair = turned(middle, fit.poses, place, axis, angle);
      const PairDerivatives by = derivatives_of(pair, fit.poses, place);
      with += by.transpose() * covariance_of(pair, fit.poses, place, fit.scatter).inverse() * by;
    }
    more.push_back(deviations_with(
        with, fmt::format("2 more, turned by {:.0f} degrees both ways about the tool's {}",
                          turn / degree, "xyz"[axis])));
  }
  return more;
}

}  // namespace slipstream
