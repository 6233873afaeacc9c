#include "slipstream/geometry/projection_matrices.h"

#include <string_view>

#include <Eigen/LU>
#include <Eigen/QR>
#include <fmt/format.h>

#include "slipstream/base/error.h"

namespace slipstream {
namespace {

/// K [R T] of a perspective matrix.
struct Posed {
  Eigen::Matrix3d intrinsic, rotation;
  Eigen::Vector3d translation;
};

Posed posed(const Eigen::Matrix<double, 3, 4>& matrix, std::string_view device) {
  const Eigen::Matrix3d left = matrix.leftCols<3>();
  const Eigen::FullPivLU<Eigen::Matrix3d> lu(left);
  if (!matrix.allFinite() || !lu.isInvertible()) {
    throw Error(fmt::format("{}: its projection matrix is not one of a camera", device));
  }
  // K R = left: with the rows and columns of both turned around it is an orthogonal times an upper
  // triangular matrix of the transpose.
  const Eigen::Matrix3d turned = left.colwise().reverse().transpose();
  const Eigen::HouseholderQR<Eigen::Matrix3d> qr(turned);
  const Eigen::Matrix3d upper = qr.matrixQR().triangularView<Eigen::Upper>();
  const Eigen::Matrix3d orthogonal = qr.householderQ();
  Eigen::Matrix3d K = upper.transpose().reverse();
  Eigen::Matrix3d R = orthogonal.transpose().colwise().reverse();
  const Eigen::Vector3d signs = K.diagonal().cwiseSign();
  K = (K * signs.asDiagonal()).eval();
  R = (signs.asDiagonal() * R).eval();
  Eigen::Vector3d T = K.triangularView<Eigen::Upper>().solve(matrix.col(3));
  if (R.determinant() < 0) {  // the matrix is known up to its sign
    R = -R;
    T = -T;
  }
  const Eigen::Matrix3d intrinsic = K.triangularView<Eigen::Upper>();
  return {intrinsic / K(2, 2), R, T};
}

}  // namespace

ProjectionMatrices projection_matrices(const Scanner& scanner, Axis axis) {
  Eigen::Matrix<double, 3, 4> camera = Eigen::Matrix<double, 3, 4>::Zero();
  camera.leftCols<3>() = scanner.camera.intrinsic;

  Eigen::Matrix<double, 3, 4> pose;
  pose << scanner.rotation, scanner.translation;
  const Eigen::Matrix<double, 3, 4> projector = scanner.projector.intrinsic * pose;
  const int length = length_along(axis, scanner.projector.size);
  return {camera, projector.row(axis == Axis::x ? 0 : 1) / length, projector.row(2)};
}

Scanner scanner_of(const Eigen::Matrix<double, 3, 4>& camera, Size camera_size,
                   const Eigen::Matrix<double, 3, 4>& projector, Size projector_size) {
  const Posed first = posed(camera, "camera"), second = posed(projector, "projector");
  const Eigen::Matrix3d rotation = second.rotation * first.rotation.transpose();
  return {.camera = {.intrinsic = first.intrinsic, .distortion = {}, .size = camera_size},
          .projector = {.intrinsic = second.intrinsic, .distortion = {}, .size = projector_size},
          .rotation = rotation,
          .translation = second.translation - rotation * first.translation};
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
