#include "merge/turntable_views.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "merge/surface_fit.h"

namespace slipstream {

std::vector<PairPose> pair_poses(std::span<const ViewLink> links) {
  std::vector<PairPose> pairs;
  for (const ViewLink& link : links) {
    pairs.push_back({link.first, link.second, link.alignment.pose, link.alignment.information,
                     link.alignment.centre});
  }
  return pairs;
}

void refine_on_surfaces(const std::vector<PreparedView>& views, std::span<const PairPose> pairs,
                        TurntableFit& fit, bool hold_step) {
  constexpr int rounds = 6;
  constexpr float first_reach = 4, last_reach = 2;  // of a match, in spacings

  // 1. Only pairs that agree: pairs of a moved view say little about the axis.
  std::vector<PairPose> agreeing;
  for (std::size_t k = 0; k < pairs.size(); ++k) {
    if (fit.agrees[k]) agreeing.push_back(pairs[k]);
  }

  const auto matches_of = [&](const PairPose& pair, const Eigen::Isometry3d& pose, float reach) {
    const SurfaceSamples first = fine_surface(views[pair.first]);
    const SurfaceSamples second = fine_surface(views[pair.second]);
    return match_surfaces(first, second, pose, reach * std::max(first.spacing, second.spacing));
  };

  // 2. New matches from round to round, ever closer.
  const Turntable before = fit.table;
  for (int round = 0; round < rounds; ++round) {
    const float reach = round < rounds / 2 ? first_reach : last_reach;
    const auto equations = [&](std::size_t k, const Eigen::Isometry3d& pose) {
      const std::vector<SurfaceMatch> matches = matches_of(agreeing[k], pose, reach);
      const Eigen::Vector3d centre = matches.empty() ? agreeing[k].centre : centre_of(matches);
      const SurfaceEquations of_pair = equations_of(matches, centre);
      return PairEquations{of_pair.squares, of_pair.right, of_pair.information, centre};
    };
    fit.table = refined_turntable(fit.table, agreeing, equations, 1, hold_step);
  }

  // 3. The deviations, as if only independent matches counted.
  PatchScatter scatter(patch_of(views.front()));
  for (const PairPose& pair : agreeing) {
    const Eigen::Isometry3d pose = pose_on(fit.table, pair.first, pair.second);
    const std::vector<SurfaceMatch> matches = matches_of(pair, pose, last_reach);
    const Eigen::Vector3d centre = centre_of(matches);
    scatter.add(pair.first, pair.second, pose, matches, centre,
                motion_by_parameters(fit.table, pair, centre, hold_step));
  }
  const double growth = std::sqrt(scatter.matches_each());
  fit.table.direction_sigma *= growth;
  fit.table.point_sigma *= growth;
  fit.table.step_sigma *= growth;

  // 4. The views follow; a moved one stays as far from its place as it was.
  for (std::size_t view = 0; view < fit.poses.size(); ++view) {
    fit.poses[view] =
        fit.poses[view] * pose_on(before, 0, view).inverse() * pose_on(fit.table, 0, view);
  }
}

}  // namespace slipstream
