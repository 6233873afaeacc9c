#pragma once

#include <span>
#include <vector>

#include "merge/joint_alignment.h"
#include "merge/prepared_view.h"
#include "merge/turntable.h"

namespace slipstream {

/// The joined pairs, for fit_turntable.
std::vector<PairPose> pair_poses(std::span<const ViewLink> links);

/// Moves axis and angles to where the surfaces of all pairs that agree with the turntable lie
/// nearest to each other, weighted by their noise, and the views with it. `hold_step`: it is known.
void refine_on_surfaces(const std::vector<PreparedView>& views, std::span<const PairPose> pairs,
                        TurntableFit& fit, bool hold_step = false);

}  // namespace slipstream
