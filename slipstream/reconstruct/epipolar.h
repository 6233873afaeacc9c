#pragma once

#include <complex>
#include <functional>

#include "slipstream/geometry/scan.h"
#include "slipstream/geometry/triangulator.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

// Epipolar geometry: checks with patterns along the other axis, and a second camera.
namespace slipstream {

/// Distance of a projector pixel from the epipolar line of a camera pixel.
struct EpipolarDistance {
  double distance = 0;  ///< projector pixels, signed, in the undistorted image
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();  ///< unit normal of the line
};

/// `ray`: of the camera pixel, (u, v, 1) in the camera's frame; `x`, `y`: projector coordinates
/// along both axes. NaN where the projector's lens model has no inverse.
EpipolarDistance epipolar_distance(const Scanner& scanner, const Eigen::Vector3d& ray, double x,
                                   double y);

/// Result of comparing a scan with patterns along the other axis. It reveals only errors across the
/// epipolar line: where the line runs along x, errors of x alone stay hidden.
struct EpipolarCheck {
  double median = 0;         ///< of the points' distances, projector pixels
  double median_length = 0;  ///< of their absolute values
  double median_sigma = 0;   ///< of their standard deviations due to noise
  std::size_t doubted = 0;   ///< points farther off than noise explains

  /// Whether the distances far exceed noise, so that calibration and scan do not match.
  [[nodiscard]] bool contradicts() const;
};

/// Compares a cloud and its maps, along x, with `other`, a scan of the same scene along y. Sets the
/// maps' epipolar distance. Marks points as `doubtful_order` if they are off their epipolar lines
/// by more than 5 standard deviations, or half a pixel if that is more. If more than a third are,
/// marks all points, since the rest are close only by chance. Throws Error if the frames of `other`
/// do not fit the setup or do not give coordinates by themselves.
EpipolarCheck check_epipolar(const EngineSetup& setup, const Scan& other, Maps& maps, Cloud& cloud);

/// Modulation and phase as one complex number, B exp(i phi). Unlike the phase it has no jump at 2
/// pi, and it stays smooth where gamma distorts the phase, so it can be interpolated.
using Phasor = std::complex<double>;

/// Decoded images of one camera.
struct CameraPhases {
  BasicMaps<double> maps;
  /// One per band, from few periods to many; a single band twice, because it is searched twice.
  std::vector<Image<Phasor>> bands;
  Image<Validity> validity;  ///< `too_dark`, `saturated` or `valid`
};

/// Transform from the first camera's frame to the second's.
struct Stereo {
  Stereo(const Scanner& first, const Scanner& second);

  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;  ///< mm
};

/// Image of one ray of the first camera in the second camera, by depth.
struct EpipolarLine {
  const Stereo& stereo;
  const Lens& camera;
  Eigen::Vector3d ray;
  const CameraPhases& seen;

  [[nodiscard]] Eigen::Vector2d pixel(double depth) const;

  /// Phase at that depth less the phase of `reference`, wrapped, rad; NaN beside an invalid pixel.
  [[nodiscard]] double difference(const Image<Phasor>& phase, Phasor reference, double depth) const;

  /// Change of depth that moves the image in the second camera by one pixel, mm.
  [[nodiscard]] double depth_of_a_pixel(double depth) const;
};

/// Decoded images of a camera, with the triangulator of its pixels.
struct SeeingCamera {
  const CameraPhases& phases;
  const Triangulator& triangulate;
};

/// Projector coordinates of the pixels of `camera` from a single band of many periods. Chooses the
/// fringe order whose point the other camera sees under the same phase. Wrong orders can match by
/// chance, so all pixels of a window vote, as far as the phase continues without a jump. NaN if two
/// orders fit, or none. `possible`: whether a surface may be at this point of the camera's frame.
Image<double> order_by_other_camera(const SeeingCamera& camera, const SeeingCamera& other,
                                    double periods,
                                    const std::function<bool(const Eigen::Vector3d&)>& possible);

}  // namespace slipstream
