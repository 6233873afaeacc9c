#pragma once

#include <array>

#include <Eigen/Core>

#include "geometry/triangulator.h"
#include "reconstruct/camera_phases.h"

namespace slipstream {

/// The epipolar lines of a camera's pixels in another camera beside the same projector, computed
/// once for a rig. A point of a pixel's ray is given by its inverse depth w = 1 / Z, 1 / mm, in the
/// camera's frame: w is almost linear in the projector coordinate, and the point's image in the
/// other camera is (ray + w translation) projected.
class EpipolarTables {
 public:
  /// `camera`, `other`: each with the projector. Throws Error as Triangulator does.
  EpipolarTables(const Scanner& camera, const Scanner& other, Axis axis);

  [[nodiscard]] Size size() const { return rays_.size(); }
  /// Whether the pixel has a ray: not if the lens model is not invertible there.
  [[nodiscard]] bool has_ray(int column, int row) const { return turned(column, row).allFinite(); }
  /// X / Z and Y / Z of the pixel's points.
  [[nodiscard]] Eigen::Vector2f direction(int column, int row) const {
    return (turn_.transpose() * turned(column, row)).head<2>();
  }

  /// w at projector coordinate y, to a part in 1e4: the start of a search.
  [[nodiscard]] float inverse_depth(int column, int row, float y) const;

  /// Z of the point in the other camera's frame, mm.
  [[nodiscard]] float other_depth(int column, int row, float w) const {
    return (turned(column, row).z() + w * translation_.z()) / w;
  }

  /// w at a depth of the camera's frame, or of the other's if `of_other`; not positive behind the
  /// camera.
  [[nodiscard]] double inverse_of(int column, int row, double depth, bool of_other) const {
    if (!of_other) return 1 / depth;
    return turned(column, row).z() / (depth - translation_.z());
  }

  /// The point's pixel in the other camera; NaN behind it.
  [[nodiscard]] Eigen::Vector2f place(int column, int row, float w) const;

  /// Projector coordinate of the point, exactly; NaN behind the projector.
  [[nodiscard]] double coordinate_at(int column, int row, double w) const;

 private:
  static constexpr int terms = 5;
  /// w as a polynomial in the coordinate, which maps [least_y, 1 - least_y] to [-1, 1].
  using Polynomial = std::array<float, terms>;
  static constexpr float least_y = -0.02F;

  struct Ray {
    std::array<float, 3> turned{};  ///< (u, v, 1) in the other camera's frame
    Polynomial depth{};
  };

  /// By how much the residual map of the other camera moves a pixel.
  struct Shift {
    float x = 0, y = 0;
  };

  [[nodiscard]] Eigen::Map<const Eigen::Vector3f> turned(int column, int row) const {
    return Eigen::Map<const Eigen::Vector3f>(rays_(column, row).turned.data());
  }
  void fill_depths(const Triangulator& triangulate);
  void fill_shifts(const Lens& other);
  [[nodiscard]] Eigen::Vector2f shift_near(const Eigen::Vector2f& ideal) const;

  Scanner scanner_;
  Axis axis_;

  Eigen::Matrix3f turn_;         ///< from the camera's frame to the other's
  Eigen::Vector3f translation_;  ///< mm

  std::array<float, untilted_coefficient_count> lens_{};  ///< of the other camera
  bool straight_ = true;                                  ///< the lens does not bend
  Image<Shift> shifts_;                                   ///< empty without a residual map
  bool tilted_ = false;
  Eigen::Matrix3f sensor_;  ///< from bent directions to multiples of pixels, with its tilt

  Image<Ray> rays_;
};

/// Interpolated phasor of a camera, or 0 beside an invalid pixel.
Phasor phasor_at(const CameraPhases& camera, const Image<Phasor>& band, const Eigen::Vector2f& at);
/// The same from the four nearest pixels, in a third of the time: biased where the phase bends.
Phasor near_phasor(const CameraPhases& camera, const Image<Phasor>& band,
                   const Eigen::Vector2f& at);

}  // namespace slipstream
