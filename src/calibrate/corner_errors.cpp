#include "calibrate/corner_errors.h"

namespace slipstream {
namespace {

/// Sets a parameter's block of the Jacobian if Ceres requests it.
template <int Columns, class Derivative>
void set_block(double** jacobians, int block, const Derivative& derivative) {
  using Block = Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Columns, Eigen::RowMajor>>;
  if (jacobians == nullptr || jacobians[block] == nullptr) return;
  Block(jacobians[block], derivative.rows(), Columns) = derivative;
}

}  // namespace

Eigen::Matrix4d to_pair_residuals(const Eigen::Matrix2d& slope, const PixelDeviations& deviations) {
  Eigen::Matrix4d to_residuals;
  to_residuals << Eigen::Matrix2d::Identity() / deviations.camera, Eigen::Matrix2d::Zero(),
      -slope / deviations.projector, Eigen::Matrix2d::Identity() / deviations.projector;
  return to_residuals;
}

bool CornerError::Evaluate(const double* const* parameters, double* residuals,
                           double** jacobians) const {
  const MovedPoint in_base =
      moved_point(parameters[2], Eigen::Map<const Eigen::Vector3d>(parameters[3]));
  const MovedPoint in_device = moved_point(parameters[1], in_base.point);
  const SeenPoint predicted = seen_point(parameters[0], in_device.point);
  Eigen::Map<Eigen::Vector2d>{residuals} = (seen_ - predicted.pixel) / deviation_;
  if (jacobians == nullptr) return true;

  // By the chain rule: pixel by device point, device point by motion, pose and place.
  const Eigen::Matrix<double, 2, 3> by_device_point = -predicted.by_point / deviation_;
  const Eigen::Matrix<double, 2, 3> by_point = by_device_point * in_device.by_point;
  set_block<lens_number_count>(jacobians, 0, -predicted.by_lens / deviation_);
  set_block<6>(jacobians, 1, by_device_point * in_device.by_pose);
  set_block<6>(jacobians, 2, by_point * in_base.by_pose);
  set_block<3>(jacobians, 3, by_point * in_base.by_point);
  return true;
}

bool PairError::Evaluate(const double* const* parameters, double* residuals,
                         double** jacobians) const {
  const MovedPoint in_base =
      moved_point(parameters[4], Eigen::Map<const Eigen::Vector3d>(parameters[5]));
  const MovedPoint in_camera = moved_point(parameters[2], in_base.point);
  const MovedPoint in_projector = moved_point(parameters[3], in_base.point);
  const SeenPoint camera = seen_point(parameters[0], in_camera.point);
  const SeenPoint projector = seen_point(parameters[1], in_projector.point);

  Eigen::Vector4d distances;
  distances << camera_seen_ - camera.pixel, projector_seen_ - projector.pixel;
  Eigen::Map<Eigen::Vector4d>{residuals} = to_residuals_ * distances;
  if (jacobians == nullptr) return true;

  // By the chain rule; the pose and the place move the point in both devices' frames.
  const Eigen::Matrix<double, 4, 2> by_camera = -to_residuals_.leftCols<2>();
  const Eigen::Matrix<double, 4, 2> by_projector = -to_residuals_.rightCols<2>();
  const Eigen::Matrix<double, 4, 3> by_camera_point = by_camera * camera.by_point;
  const Eigen::Matrix<double, 4, 3> by_projector_point = by_projector * projector.by_point;
  const Eigen::Matrix<double, 4, 3> by_point =
      by_camera_point * in_camera.by_point + by_projector_point * in_projector.by_point;

  set_block<lens_number_count>(jacobians, 0, by_camera * camera.by_lens);
  set_block<lens_number_count>(jacobians, 1, by_projector * projector.by_lens);
  set_block<6>(jacobians, 2, by_camera_point * in_camera.by_pose);
  set_block<6>(jacobians, 3, by_projector_point * in_projector.by_pose);
  set_block<6>(jacobians, 4, by_point * in_base.by_pose);
  set_block<3>(jacobians, 5, by_point * in_base.by_point);
  return true;
}

bool PrintError::Evaluate(const double* const* parameters, double* residuals,
                          double** jacobians) const {
  const Eigen::Map<const Eigen::Vector3d> place(parameters[0]);
  Eigen::Map<Eigen::Vector3d>{residuals} = (place - printed_) / deviation_;
  set_block<3>(jacobians, 0, Eigen::Matrix3d::Identity() / deviation_);
  return true;
}

}  // namespace slipstream
