#include "slipstream/geometry/projection_matrices.h"

#include <Eigen/LU>

namespace slipstream {

ProjectionMatrices projection_matrices(const Scanner& scanner, Axis axis) {
  Eigen::Matrix<double, 3, 4> camera = Eigen::Matrix<double, 3, 4>::Zero();
  camera.leftCols<3>() = scanner.camera.intrinsic;

  Eigen::Matrix<double, 3, 4> pose;
  pose << scanner.rotation, scanner.translation;
  const Eigen::Matrix<double, 3, 4> projector = scanner.projector.intrinsic * pose;
  const int length = length_along(axis, scanner.projector.size);
  return {camera, projector.row(axis == Axis::x ? 0 : 1) / length, projector.row(2)};
}

Eigen::Vector3d triangulate(const ProjectionMatrices& matrices, double x, double y, double y_p) {
  const auto& m = matrices.camera;
  Eigen::Matrix<double, 3, 4> equations;
  equations << m.row(0) - m.row(2) * x,  //
      m.row(1) - m.row(2) * y,           //
      matrices.projector_coordinate - matrices.projector_depth * y_p;
  const Eigen::Matrix3d left = equations.leftCols<3>();
  const Eigen::Vector3d right = -equations.col(3);
  return left.inverse() * right;  // (1.15)
}

}  // namespace slipstream
