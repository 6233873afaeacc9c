#pragma once

#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "merge/joint_alignment.h"

namespace slipstream {

/// Each view's frame to a common one; nullopt for views without a pose.
using Poses = std::vector<std::optional<Eigen::Isometry3d>>;

/// Largest displacement, mm, of the second view's points between a link's pose and one by the
/// others.
double contradiction(const PreparedView& second, const Eigen::Isometry3d& pose,
                     const Eigen::Isometry3d& other);

/// Spreads the contradictions between the links over all poses; links far off the others lose
/// weight (Cauchy).
void balance_links(const std::vector<PreparedView>& views, const std::vector<ViewLink>& links,
                   Poses& poses);

/// Refines the poses of all views that have one, by the distances between linked surfaces. The
/// first view stays.
void refine_jointly(const std::vector<PreparedView>& views, const std::vector<ViewLink>& links,
                    int rounds, Poses& poses);

}  // namespace slipstream
