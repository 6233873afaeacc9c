#pragma once

#include <variant>

#include <Eigen/Core>

#include "slipstream/base/image.h"
#include "slipstream/geometry/point_forms.h"
#include "slipstream/geometry/scanner.h"

namespace slipstream {

/// Which of the equivalent ways turns a pixel and a projector coordinate into a point.
enum class PointMethod {
  inverse,  ///< Eq. (1.15), a matrix inverted for each point
  form1,    ///< Eqs. (2.21)-(2.24)
  form2,    ///< Eqs. (2.25)-(2.28)
  form3,    ///< Eqs. (2.29)-(2.31)
};

/// Camera pixel and decoded projector coordinate to a 3-D point. Lens distortion is honoured on
/// both sides: the camera's is a function of the pixel and stands in the table; the projector's
/// depends on where along the stripe the point lies and is solved for each point, to rounding. The
/// phase itself is never resampled.
class Triangulator {
 public:
  /// Builds the table for every camera pixel. Throws Error for a scanner that is not valid or sees
  /// no depth along `axis`.
  Triangulator(const Scanner& scanner, Axis axis, PointMethod method);

  [[nodiscard]] const Scanner& scanner() const { return scanner_; }
  [[nodiscard]] Axis axis() const { return axis_; }

  /// Point in the camera's frame, mm, for the pixel and the projector coordinate y, [0, 1), as
  /// decoded. NaN where there is none: the ray misses the plane, or the lens model has no inverse.
  [[nodiscard]] Eigen::Vector3d operator()(int column, int row, double y) const;

 private:
  template <class PointOf>
  Eigen::Vector3d through_projector_lens(const PointOf& point_of, double y) const;

  Scanner scanner_;
  Axis axis_;
  ProjectionMatrices matrices_;
  std::variant<Image<PixelPosition>, Image<PointForm1>, Image<PointForm2>, Image<PointForm3>>
      table_;
};

}  // namespace slipstream
