#include "slipstream/calibrate/orientation.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

/// A of the best projector pixel = A camera pixel + b.
Eigen::Matrix2d affine_map(const BoardView& view) {
  const int count = lit_corners(view);
  Eigen::MatrixX3d camera(count, 3);
  Eigen::MatrixX2d projector(count, 2);
  int row = 0;
  for (std::size_t i = 0; i < view.camera.size(); ++i) {
    if (!view.projector[i].allFinite()) continue;
    camera.row(row) << view.camera[i].transpose(), 1;
    projector.row(row) = view.projector[i].transpose();
    ++row;
  }
  const Eigen::Matrix<double, 3, 2> solution = camera.colPivHouseholderQr().solve(projector);
  return solution.topRows<2>().transpose();
}

}  // namespace

void require_same_handedness(const BoardView& view) {
  const Eigen::Matrix2d A = affine_map(view);
  if (A.determinant() > 0) return;
  if (A.diagonal().squaredNorm() < A.squaredNorm() / 2) {
    throw Error(fmt::format(
        "{}: projector x and y are swapped; the scan along x seems to be the one along y: "
        "check the order of the frames or --first-axis",
        view.name));
  }
  throw Error(
      fmt::format("{}: the projector's picture is mirrored along {} (or the camera's is); "
                  "turn the mirroring off in the device",
                  view.name, A(0, 0) < 0 ? "x" : "y"));
}

}  // namespace slipstream
