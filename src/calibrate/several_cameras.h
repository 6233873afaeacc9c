#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "slipstream/geometry_calibration.h"

namespace slipstream {

/// How a further camera stands to the first.
struct CameraPose {
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();    ///< first camera's frame to this one's
  Eigen::Vector3d rotation_sigma = Eigen::Vector3d::Zero();  ///< rad, about x, y, z
  Eigen::Vector3d translation_sigma = Eigen::Vector3d::Zero();  ///< mm
};

/// Several cameras of one projector.
struct CamerasCalibration {
  /// Each camera with the projector, whose lens is the same in all; poses in its own frame.
  std::vector<GeometryCalibration> cameras;
  std::vector<CameraPose> poses;  ///< of all cameras but the first
};

/// Adjusts calibrations of single cameras together: they share the projector, the board and, in
/// views of the same name, its poses. `printed` and `spacing`: see calibrate_geometry. Keeps the
/// chosen lens models; updates scanners, poses, standard deviations, RMS and qualities. Standard
/// deviations of the projector's pose are those of the fit or the jackknife, whichever is larger,
/// for the first camera; for further ones those of the jackknife alone. Throws Error for fewer than
/// two cameras, cameras that share fewer than `fewest_poses` views with those before, projectors of
/// different sizes, residual maps, and poses that do not determine the calibration.
CamerasCalibration calibrate_together(std::vector<GeometryCalibration> alone,
                                      const BoardPlaces& printed, double spacing,
                                      const GeometryCalibrationSettings& settings = {});

}  // namespace slipstream
