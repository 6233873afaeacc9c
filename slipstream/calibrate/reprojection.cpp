#include "slipstream/calibrate/reprojection.h"

namespace slipstream {
namespace {

Squares squares_of(const std::vector<Eigen::Vector2d>& residuals) {
  Squares squares;
  for (const Eigen::Vector2d& residual : residuals) {
    if (residual.allFinite()) squares.add(residual.squaredNorm());
  }
  return squares;
}

}  // namespace

void Reprojection::add(const Reprojection& other) {
  camera.add(other.camera);
  projector.add(other.projector);
}

ReprojectionRms Reprojection::rms() const {
  Squares both = camera;
  both.add(projector);
  return {camera.rms(), projector.rms(), both.rms()};
}

Reprojection reprojection(const BoardView& view, const BundleState& state, std::size_t v) {
  const auto& [scanner, poses, places] = state;
  return {squares_of(camera_residuals(view, scanner, poses[v], places)),
          squares_of(projector_residuals(view, scanner, poses[v], places))};
}

}  // namespace slipstream
