#pragma once

#include <utility>

#include <Eigen/Core>
#include <ceres/sized_cost_function.h>

#include "calibrate/pixel_derivatives.h"
#include "calibrate/reprojection.h"

// Residuals of a board's corners, as Ceres adjusts them. Blocks of parameters: a lens has
// lens_number_count numbers, a pose its axis times angle and translation, a place x, y and z.
namespace slipstream {

/// From pixel distances of camera and projector to residuals: subtracts the camera's part from the
/// projector's, and divides by the deviations. `slope`: see BoardView::slopes.
Eigen::Matrix4d to_pair_residuals(const Eigen::Matrix2d& slope, const PixelDeviations& deviations);

/// Residual of a corner in a device, in standard deviations. Parameters: lens, motion from the
/// base's frame to the device's (of the base itself zero and held), board's pose in the base's
/// frame, place.
class CornerError : public ceres::SizedCostFunction<2, lens_number_count, 6, 6, 3> {
 public:
  CornerError(Eigen::Vector2d seen, double deviation)  // pixels
      : seen_(std::move(seen)), deviation_(deviation) {}

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Vector2d seen_;
  double deviation_;
};

/// Residuals of a corner in a camera and in the projector, standard deviations; the projector's
/// without the part that the camera's causes. Parameters: lens of the camera, lens of the
/// projector, motions from the base's frame to the camera's and to the projector's, pose, place.
class PairError
    : public ceres::SizedCostFunction<4, lens_number_count, lens_number_count, 6, 6, 6, 3> {
 public:
  PairError(Eigen::Vector2d camera_seen, Eigen::Vector2d projector_seen,
            const Eigen::Matrix2d& slope, const PixelDeviations& deviations)
      : camera_seen_(std::move(camera_seen)),
        projector_seen_(std::move(projector_seen)),
        to_residuals_(to_pair_residuals(slope, deviations)) {}

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Vector2d camera_seen_, projector_seen_;
  Eigen::Matrix4d to_residuals_;
};

/// Printing error of a corner, in standard deviations.
class PrintError : public ceres::SizedCostFunction<3, 3> {
 public:
  PrintError(Eigen::Vector3d printed, double deviation)  // mm
      : printed_(std::move(printed)), deviation_(deviation) {}

  bool Evaluate(const double* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  Eigen::Vector3d printed_;
  double deviation_;
};

}  // namespace slipstream
