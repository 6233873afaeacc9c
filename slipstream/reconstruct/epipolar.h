#pragma once

#include <complex>
#include <functional>

#include "slipstream/geometry/scan.h"
#include "slipstream/geometry/triangulator.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

// Where one view sees what the other does: patterns along the other axis, a second camera.
namespace slipstream {

/// How far a projector pixel lies from the epipolar line of a camera pixel.
struct EpipolarDistance {
  double distance = 0;  ///< projector pixels, signed, in the picture without the lens's distortion
  Eigen::Vector2d normal = Eigen::Vector2d::Zero();  ///< of the line, unit length
};

/// `ray`: of the camera pixel, (u, v, 1) in its frame; `x`, `y`: projector coordinates along both
/// axes. NaN where the projector's lens model has no inverse.
EpipolarDistance epipolar_distance(const Scanner& scanner, const Eigen::Vector3d& ray, double x,
                                   double y);

/// What the patterns along the other axis say of a scan. Only the part of an error across the
/// epipolar line shows: where that runs along x, mistakes of x alone do not.
struct EpipolarCheck {
  double median = 0;         ///< of the distances of points, projector pixels
  double median_length = 0;  ///< likewise without their signs
  double median_sigma = 0;   ///< what noise does to it: one standard deviation
  std::size_t doubted = 0;   ///< points that lay farther off than noise explains

  /// Whether the distances are far beyond noise, so that calibration and scan do not fit.
  [[nodiscard]] bool contradicts() const;
};

/// Compares a cloud and its maps, along x, with `other`, the same seen under patterns along y:
/// sets the maps' epipolar distance and makes points farther than 5 standard deviations, or half a
/// pixel where that is more, from their epipolar lines `doubtful_order`; all of them where more
/// than a third are: the others lie there by chance. Throws Error where its frames do not fit the
/// setup or give no coordinate alone.
EpipolarCheck check_epipolar(const EngineSetup& setup, const Scan& other, Maps& maps, Cloud& cloud);

/// Modulation and phase as one number, B exp(i phi): unlike the phase it has no seam, and it stays
/// smooth where gamma bends the phase, so that it can be interpolated.
using Phasor = std::complex<double>;

/// What one camera knows of every pixel.
struct CameraPhases {
  BasicMaps<double> maps;
  /// Of each band, from few periods to many; of a single one twice, for it is looked for twice.
  std::vector<Image<Phasor>> bands;
  Image<Validity> validity;  ///< too dark, saturated, or valid
};

/// From the first camera's frame to the second's.
struct Stereo {
  Stereo(const Scanner& first, const Scanner& second);

  Eigen::Matrix3d rotation;
  Eigen::Vector3d translation;  ///< mm
};

/// The second camera along one ray of the first: what it sees at each depth.
struct EpipolarLine {
  const Stereo& stereo;
  const Lens& camera;
  Eigen::Vector3d ray;
  const CameraPhases& seen;

  [[nodiscard]] Eigen::Vector2d pixel(double depth) const;

  /// Phase there minus that of `reference`, around the circle; NaN where a pixel beside the place
  /// is not valid.
  [[nodiscard]] double difference(const Image<Phasor>& phase, Phasor reference, double depth) const;

  /// Depth that moves the place in the second camera by one pixel, mm.
  [[nodiscard]] double depth_of_a_pixel(double depth) const;
};

/// What a camera sees, and where its pixels' coordinates lie.
struct SeeingCamera {
  const CameraPhases& phases;
  const Triangulator& triangulate;
};

/// Of a single band of many periods, the projector coordinate of each pixel of `camera`: the fringe
/// order is that of the point that the other camera sees under the same phase. As wrong orders meet
/// that by chance, the pixels of a window count, as far as the phase runs on without a leap. NaN
/// where two orders fit, or none. `possible`: whether a surface may be there in the camera's frame.
Image<double> order_by_other_camera(const SeeingCamera& camera, const SeeingCamera& other,
                                    double periods,
                                    const std::function<bool(const Eigen::Vector3d&)>& possible);

}  // namespace slipstream
