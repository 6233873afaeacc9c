#include "calibrate/hand_eye_consensus.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <utility>

#include "base/linear_algebra.h"
#include "base/numbers.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "calibrate/left_out.h"
#include "geometry/rotation.h"

namespace slipstream {
namespace {

/// Poses that agree with the closed form, which half of them determine.
Used agreeing_with(const HandEyePoses& start, const std::vector<PosePair>& pairs, EyePlace place) {
  constexpr double reach = 8;  // of the median error
  constexpr double least_rotation = 0.02 * degree, least_translation = 0.05;

  std::vector<double> rotations, translations;
  for (const PosePair& pair : pairs) {
    const HandEyeError error = sizes_of(error_of(pair, start, place));
    rotations.push_back(error.rotation);
    translations.push_back(error.translation);
  }

  const double rotation_limit = reach * median(rotations) + least_rotation;
  const double translation_limit = reach * median(translations) + least_translation;
  Used used;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    used.push_back(rotations[i] <= rotation_limit && translations[i] <= translation_limit);
  }
  return used;
}

/// Error of a pair in a calibration without it: its square in units of its covariance, over 6.
double square_of(const PosePair& pair, const AdjustedHandEye& fit, EyePlace place) {
  const PoseError error = error_of(pair, fit.poses, place);
  const PairDerivatives by = derivatives_of(pair, fit.poses, place);
  const Eigen::Matrix<double, 6, 6> covariance =
      covariance_of(pair, fit.poses, place, fit.scatter) + by * fit.covariance * by.transpose();
  return error.dot(Matrix6(inverse_of(covariance)) * error) / 6;
}

/// Leaves out each used pose in turn; of many poses several at once.
LeftOut left_out_of(const std::vector<PosePair>& pairs, const Used& used, const HandEyePoses& start,
                    EyePlace place) {
  constexpr std::size_t most_groups = 60;
  const auto count = static_cast<std::size_t>(std::ranges::count(used, true));
  const std::size_t groups = std::min(count, most_groups);

  // 1. The group of each used pose.
  std::vector<std::size_t> group(pairs.size(), groups);
  std::size_t next = 0;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (used[i]) group[i] = next++ % groups;
  }

  // 2. A calibration without each group.
  LeftOut result{.poses = {},
                 .errors = std::vector<std::optional<PoseError>>(pairs.size()),
                 .squares = std::vector<double>(pairs.size(), 0)};
  for (std::size_t g = 0; g < groups; ++g) {
    Used rest = used;
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (group[i] == g) rest[i] = false;
    }

    const AdjustedHandEye fit = adjusted_hand_eye(used_pairs(pairs, rest), start, place);
    result.poses.push_back(fit.poses);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (group[i] != g) continue;
      result.errors[i] = error_of(pairs[i], fit.poses, place);
      result.squares[i] = square_of(pairs[i], fit, place);
    }
  }
  return result;
}

constexpr std::size_t fewest_for_left_out = 4;

/// Largest `squares` of a pose that belongs to the others. Few poses scatter more in units of a
/// standard deviation that is itself estimated from them.
double largest_square(std::size_t used) {
  const double freedom = static_cast<double>(used) - 5;
  if (freedom <= 0) return std::numeric_limits<double>::infinity();
  return 6 * (1 + std::pow(9 / freedom, 2));
}

bool matters(const HandEyeError& error) {
  return error.translation > 0.3 || error.rotation > 0.05 * degree;  // mm, rad
}

/// The worst of the poses whose squares are above the limit: one, as it may spoil others, and of
/// many poses one in 40, as each round of these takes long.
std::vector<std::size_t> odd_poses(const LeftOut& left_out, double limit) {
  constexpr std::size_t poses_for_each = 40;
  const std::vector<double>& squares = left_out.squares;

  std::vector<std::size_t> odd;
  for (std::size_t i = 0; i < squares.size(); ++i) {
    if (squares[i] > limit && matters(sizes_of(*left_out.errors[i]))) odd.push_back(i);
  }

  std::ranges::sort(odd, std::greater(), [&](std::size_t i) { return squares[i]; });
  odd.resize(std::min(odd.size(), 1 + squares.size() / poses_for_each));
  return odd;
}

void require_enough_agree(const Used& used) {
  const auto agree = static_cast<std::size_t>(std::ranges::count(used, true));
  throw_if(agree < 3 || 5 * agree < 3 * used.size(),
           "only {} of {} poses agree with each other; check that the rows of robot and boards "
           "belong together, and that the board or the camera did not move",
           agree, used.size());
}

}  // namespace

RobustFit robust_fit(const std::vector<PosePair>& pairs, const HandEyePoses& start,
                     EyePlace place) {
  Used used = agreeing_with(start, pairs, place);
  HandEyePoses poses = start;

  while (true) {
    require_enough_agree(used);
    const AdjustedHandEye fit = adjusted_hand_eye(used_pairs(pairs, used), poses, place);
    poses = fit.poses;
    const auto count = static_cast<std::size_t>(std::ranges::count(used, true));
    if (count < fewest_for_left_out) return {used, fit, std::nullopt};

    // The poses that do not belong to the others, as calibrations without them see it.
    LeftOut left_out = left_out_of(pairs, used, poses, place);
    const std::vector<std::size_t> odd = odd_poses(left_out, largest_square(count));
    if (odd.empty()) return {used, fit, std::move(left_out)};
    for (const std::size_t pose : odd) used[pose] = false;
  }
}

PoseError deviation_of(const RobustFit& found) {
  const PoseError fitted = found.fit.covariance.diagonal().head<6>().cwiseSqrt();
  if (!found.left_out) return fitted;

  std::vector<PoseError> changes;
  for (const HandEyePoses& poses : found.left_out->poses) {
    const Eigen::Isometry3d &now = found.fit.poses.camera, &then = poses.camera;
    PoseError change;
    change << vector_of(now.linear().transpose() * then.linear()),
        then.translation() - now.translation();
    changes.push_back(change);
  }
  return fitted.cwiseMax(jackknife(changes));
}

std::vector<PosePair> used_pairs(const std::vector<PosePair>& pairs, const Used& used) {
  std::vector<PosePair> some;
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (used[i]) some.push_back(pairs[i]);
  }
  return some;
}

HandEyeError sizes_of(const PoseError& error) {
  return {error.head<3>().norm(), error.tail<3>().norm()};
}

}  // namespace slipstream
