#pragma once

#include <array>

#include <Eigen/Core>

#include "geometry/triangulator.h"
#include "reconstruct/camera_phases.h"

namespace slipstream {

/// What epipolar lines are computed from.
struct EpipolarLines {
  static constexpr int terms = 5;
  static constexpr float least_y = -0.02F;

  struct Ray {
    std::array<float, 3> turned{};  ///< (u, v, 1) in the other camera's frame
    /// w as a polynomial in the coordinate, which maps [least_y, 1 - least_y] to [-1, 1].
    std::array<float, terms> depth{};
  };

  /// By how much the residual map of the other camera moves a pixel.
  struct Shift {
    float x = 0, y = 0;
  };

  Image<Ray> rays;              ///< of the camera's pixels
  Eigen::Vector3f translation;  ///< from the camera's frame to the other's, mm

  std::array<float, untilted_coefficient_count> lens{};  ///< of the other camera
  bool straight = true;                                  ///< the lens does not bend
  bool tilted = false;
  Eigen::Matrix3f sensor;  ///< from bent directions to multiples of pixels, with its tilt
  Image<Shift> shifts;     ///< empty without a residual map
};

/// The epipolar lines of a camera's pixels in another camera beside the same projector, computed
/// once for a rig. A point of a pixel's ray is given by its inverse depth w = 1 / Z, 1 / mm, in the
/// camera's frame: w is almost linear in the projector coordinate, and the point's image in the
/// other camera is (ray + w translation) projected.
class EpipolarTables {
 public:
  /// `camera`, `other`: each with the projector. Throws Error as Triangulator does.
  EpipolarTables(const Scanner& camera, const Scanner& other, Axis axis);

  [[nodiscard]] Size size() const { return lines_.rays.size(); }
  [[nodiscard]] const EpipolarLines& lines() const { return lines_; }
  /// Whether the pixel has a ray: not if the lens model is not invertible there.
  [[nodiscard]] bool has_ray(int column, int row) const { return turned(column, row).allFinite(); }
  /// X / Z and Y / Z of the pixel's points.
  [[nodiscard]] Eigen::Vector2f direction(int column, int row) const {
    return (turn_.transpose() * turned(column, row)).head<2>();
  }

  /// w at projector coordinate y, to a part in 1e4: the start of a search.
  [[nodiscard]] float inverse_depth(int column, int row, float y) const;

  /// w at a depth of the camera's frame, or of the other's if `of_other`; not positive behind the
  /// camera.
  [[nodiscard]] double inverse_of(int column, int row, double depth, bool of_other) const {
    if (!of_other) return 1 / depth;
    return turned(column, row).z() / (depth - lines_.translation.z());
  }

  /// Projector coordinate of the point, exactly; NaN behind the projector.
  [[nodiscard]] double coordinate_at(int column, int row, double w) const;

 private:
  [[nodiscard]] Eigen::Map<const Eigen::Vector3f> turned(int column, int row) const {
    return Eigen::Map<const Eigen::Vector3f>(lines_.rays(column, row).turned.data());
  }
  void fill_depths(const Triangulator& triangulate);
  void fill_shifts(const Lens& other);

  Scanner scanner_;
  Axis axis_;

  Eigen::Matrix3f turn_;  ///< from the camera's frame to the other's
  EpipolarLines lines_;
};

/// Phasor of a camera between its four nearest pixels, or 0 beside an invalid one: biased where the
/// phase bends.
Phasor near_phasor(const CameraPhases& camera, const Image<Phasor>& band,
                   const Eigen::Vector2f& at);

}  // namespace slipstream
