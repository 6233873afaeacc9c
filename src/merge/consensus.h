#pragma once

#include <span>
#include <vector>

#include <Eigen/Geometry>

#include "merge/features.h"

namespace slipstream {

/// A pose that several correspondences agree on.
struct ConsensusPose {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();  ///< second to first view
  int support = 0;                                         ///< correspondences that agree with it
};

/// Poses that many correspondences agree on, those with most support first; at most `most`, each
/// distinct from the others. Most correspondences may be wrong: right ones keep distances and
/// angles between each other, and so agree with common others in pairs (second-order spatial
/// compatibility; Chen et al. 2022).
std::vector<ConsensusPose> consensus_poses(const Keypoints& first, const Keypoints& second,
                                           std::span<const Correspondence> correspondences,
                                           std::size_t most);

/// Largest distance by which two poses differ for points about `reach` from `middle`.
double largest_displacement(const Eigen::Isometry3d& a, const Eigen::Isometry3d& b,
                            const Eigen::Vector3d& middle, double reach);

}  // namespace slipstream
