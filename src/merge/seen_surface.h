#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "merge/view.h"
#include "slipstream/image.h"

namespace slipstream {

/// Where a place lies, as seen by a view's camera.
enum class Sight {
  unknown,  ///< outside the view, or beside its points
  hidden,   ///< behind the view's surface
  near,     ///< about on the surface
  clear,    ///< in front of the surface: the camera saw through this place
};

/// How far a view's camera saw in each direction: a depth picture of its points. Empty for a view
/// whose camera is unknown.
class SeenSurface {
 public:
  SeenSurface() = default;
  explicit SeenSurface(const View& view);

  /// `place`: in the view's frame; `margin`: distance that counts as near, mm.
  [[nodiscard]] Sight at(const Eigen::Vector3f& place, float margin) const;

 private:
  /// Column and row of a place, possibly outside the picture; false if behind the camera.
  [[nodiscard]] bool pixel_of(const Eigen::Vector3f& place, int& column, int& row) const;

  Eigen::Matrix3f to_picture_ = Eigen::Matrix3f::Identity();
  float pixel_ = 1;  ///< tangent of its angle
  Eigen::Vector2f corner_ = Eigen::Vector2f::Zero();
  Image<float> nearest_, farthest_;  ///< distances from the camera, mm; NaN without a point
};

}  // namespace slipstream
