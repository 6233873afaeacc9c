#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include <Eigen/Geometry>

#include "slipstream/calibration_board.h"
#include "slipstream/image.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// Square markers with numbers: AprilTag's families and OpenCV's ArUco dictionaries. In the order
/// of markers_named.
enum class Markers {
  april_36h11,
  april_36h10,
  april_25h9,
  april_16h5,
  aruco_4x4,
  aruco_5x5,
  aruco_6x6,
  aruco_7x7
};

/// "36h11", "36h10", "25h9" and "16h5", "4x4" to "7x7".
std::string_view name_of(Markers markers);

/// Throws Error for an unknown name.
Markers markers_named(std::string_view name);

/// The marker to print, `pixels_per_cell` for each of its bits, with its black border and a white
/// margin of one cell. Throws Error unless the family has this number.
Image<std::uint8_t> draw_marker(Markers markers, int number, int pixels_per_cell);

/// A marker in a picture.
struct SeenMarker {
  int number = 0;
  PixelPlaces corners;  ///< upper left, upper right, lower right and lower left as printed
};

/// All markers of the family in a picture, grey levels.
std::vector<SeenMarker> find_markers(Markers markers, const Image<float>& picture);

/// Where a marker is.
struct MarkerPose {
  /// Marker to camera, mm: its origin is the middle, x and y run right and down as printed, z away
  /// from the camera.
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  /// Standard deviations, about the marker's axes, rad, and along the camera's, mm.
  Eigen::Vector3d rotation_deviation = Eigen::Vector3d::Zero();
  Eigen::Vector3d translation_deviation = Eigen::Vector3d::Zero();
  double rms = 0;  ///< distance of its edges from the pose's, pixels
};

/// Fits the pose to the marker's four sides. `side`: of its black square, mm. Throws Error if the
/// marker is too small in the picture, its sides do not fit a square, or two poses fit them equally
/// well: far away, a tilt to either side looks the same.
MarkerPose marker_pose(Markers markers, const SeenMarker& marker, double side,
                       const Image<float>& picture, const Lens& lens);

}  // namespace slipstream
