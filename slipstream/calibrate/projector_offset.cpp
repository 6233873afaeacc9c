#include "slipstream/calibrate/projector_offset.h"

#include <cmath>

#include "slipstream/base/numbers.h"

namespace slipstream {

ProjectorOffset projector_offset(const BoardView& view, const Scanner& scanner,
                                 const Eigen::Isometry3d& start,
                                 const std::vector<Eigen::Vector3d>& places) {
  BoardView by_camera = view;
  for (Eigen::Vector2d& pixel : by_camera.projector) pixel = {nan, nan};
  const BundleState seen = bundle_adjusted({by_camera}, {scanner, {start}, places}, places,
                                           {.hold_camera = true, .hold_rig = true});
  ProjectorOffset offset;
  int count = 0;
  const auto residuals = projector_residuals(view, scanner, seen.poses.front(), places);
  for (const Eigen::Vector2d& residual : residuals) {
    if (!residual.allFinite()) continue;
    offset.mean += residual;
    offset.spread += residual.squaredNorm();
    ++count;
  }
  offset.mean /= count;
  offset.spread = std::sqrt(std::max(0.0, offset.spread / count - offset.mean.squaredNorm()));
  return offset;
}

}  // namespace slipstream
