#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include <Eigen/Geometry>

#include "calibrate/reprojection.h"
#include "slipstream/geometry_calibration.h"

namespace slipstream {

/// The views that several cameras have of one board.
struct CamerasViews {
  std::vector<BoardViews> cameras;              ///< views of each camera
  std::vector<std::vector<std::size_t>> poses;  ///< of each view: index into CamerasState::poses
};

/// All parameters that determine the pixels of several cameras and one projector.
struct CamerasState {
  std::vector<Lens> cameras;
  Lens projector;
  Eigen::Isometry3d rig;                              ///< first camera's frame to the projector's
  std::vector<Eigen::Isometry3d> cameras_from_first;  ///< its frame to each camera's
  std::vector<Eigen::Isometry3d> poses;               ///< board to the first camera's frame
  BoardPlaces places;                                 ///< the board's corners in its own frame, mm
};

struct CamerasSettings {
  std::vector<int> camera_coefficients;  ///< of each camera, see BundleSettings
  int projector_coefficients = 5;
  bool hold_cameras = false, hold_projector = false;  ///< fix the lenses
  bool hold_rig = false;                              ///< fixes CamerasState::rig
  std::optional<double> print_deviation{};            ///< mm; nullopt fixes the places
  /// A value per camera; empty: estimated, in three rounds.
  std::vector<PixelDeviations> pixel_deviations{};
};

/// Standard deviations for independent corner errors.
struct CamerasDeviation {
  std::vector<LensDeviation> cameras;
  LensDeviation projector;
  std::vector<Eigen::Matrix<double, 6, 1>> motions;  ///< turn (rad) and shift (mm): the rig's, then
                                                     ///< of the cameras after the first
};

/// From the frame of a scanner's camera to its projector's.
Eigen::Isometry3d rig_of(const Scanner& scanner);

/// A camera with the projector and its views, in its own frame.
BundleState state_of_camera(const CamerasState& state, const CamerasViews& views,
                            std::size_t camera);

/// The deviations of a camera and the projector; of their relative pose only for the first camera.
BundleDeviation deviation_of_camera(const CamerasDeviation& deviation, std::size_t camera);

/// Minimises the residuals of one or more cameras and the projector, as bundle_adjusted says. The
/// lenses must have no residual maps. If not null, `deviation` receives the standard deviations.
/// Throws Error if it does not converge, or if the poses do not determine the requested
/// `deviation`.
CamerasState jointly_adjusted(const CamerasViews& views, CamerasState start,
                              const BoardPlaces& printed, const CamerasSettings& settings,
                              CamerasDeviation* deviation = nullptr);

}  // namespace slipstream
