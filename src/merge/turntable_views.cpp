#include "merge/turntable_views.h"

#include <algorithm>
#include <cstddef>
#include <utility>

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

  // 2. New matches from round to round, ever closer.
  const Turntable before = fit.table;
  for (int round = 0; round < rounds; ++round) {
    const float reach = round < rounds / 2 ? first_reach : last_reach;
    const auto equations = [&](std::size_t k, const Eigen::Isometry3d& pose) {
      const SurfaceSamples first = fine_surface(views[agreeing[k].first]);
      const SurfaceSamples second = fine_surface(views[agreeing[k].second]);
      const float farthest = reach * std::max(first.spacing, second.spacing);
      const std::vector<SurfaceMatch> matches = match_surfaces(first, second, pose, farthest);

      const Eigen::Vector3d centre = matches.empty() ? agreeing[k].centre : centre_of(matches);
      const SurfaceEquations of_pair = equations_of(matches, centre);
      return PairEquations{of_pair.squares, of_pair.right, of_pair.information, centre};
    };
    fit.table = refined_turntable(fit.table, agreeing, equations, 1, hold_step);
  }

  // 3. The views follow; a moved one stays as far from its place as it was.
  for (std::size_t view = 0; view < fit.poses.size(); ++view) {
    fit.poses[view] =
        fit.poses[view] * pose_on(before, 0, view).inverse() * pose_on(fit.table, 0, view);
  }
}

}  // namespace slipstream
