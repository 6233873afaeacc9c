#pragma once

#include <algorithm>
#include <variant>

#include "slipstream/scanner.h"

namespace slipstream {

/// The rows of the perspective matrices used for triangulation, Liu 2010, Eqs. (1.9), (1.10). The
/// projector's coordinate row, its second for patterns along y, as printed, and its first along x,
/// is divided by the projector's length so that y^p is in [0, 1).
struct ProjectionMatrices {
  Eigen::Matrix<double, 3, 4> camera;                ///< M^c
  Eigen::Matrix<double, 1, 4> projector_coordinate;  ///< m_2^p (m_1^p for axis x) / length
  Eigen::Matrix<double, 1, 4> projector_depth;       ///< m_3^p
};

/// M^c = K^c [I 0], M^p = K^p [R T], for lenses without distortion.
ProjectionMatrices projection_matrices(const Scanner& scanner, Axis axis);

/// Point at undistorted camera pixel (x, y) and undistorted projector coordinate y_p, by inverting
/// the matrix of Eq. (1.15); right-hand side as corrected in docs/background/errata.md. Not finite
/// if the ray lies in the coordinate's plane.
Eigen::Vector3d triangulate(const ProjectionMatrices& matrices, double x, double y, double y_p);

/// A linear function of the camera pixel, p_1 x^c + p_2 y^c + p_3, for each of X, Y, Z and the
/// homogeneous coordinate: the columns are (p_x p_y p_z p_w).
using PixelPolynomial = Eigen::Matrix<double, 4, 3>;

/// The coefficients of Liu 2010, Section 2.1, after Eq. (2.24): the numerators and denominators of
/// Eq. (1.15) as linear functions of the camera pixel.
struct PointCoefficients {
  PixelPolynomial with_coordinate;     ///< a_x, a_y, a_z and c, the factors of y^p
  PixelPolynomial constant;            ///< b_x, b_y, b_z and d
  Eigen::Matrix<double, 3, 4> camera;  ///< M^c, for E and F of the third form
};

PointCoefficients point_coefficients(const ProjectionMatrices& matrices);

/// First form, Eqs. (2.21)-(2.24): 7 multiplications, 1 division, 4 additions.
struct PointForm1 {
  double A_x, B_x, A_y, B_y, A_z, B_z, C;

  [[nodiscard]] Eigen::Vector3d operator()(double y_p) const;
};

/// Third form, Eqs. (2.29)-(2.31): 3 multiplications, 1 division, 4 additions.
struct PointForm3 {
  double M_z, N_z, C, E_x, F_x, E_y, F_y;

  [[nodiscard]] Eigen::Vector3d operator()(double y_p) const;
};

/// The table entries at undistorted camera pixel (x, y), for the points of Eq. (1.15). The third
/// form gives NaN at a pixel whose ray is perpendicular to the projector's optical axis (C = 0).
PointForm1 point_form1(const PointCoefficients& coefficients, double x, double y);
PointForm3 point_form3(const PointCoefficients& coefficients, double x, double y);

/// Table of a form at each undistorted pixel; `form` is one of the functions above.
template <class Form>
Image<Form> point_table(const Image<PixelPosition>& pixels, const ProjectionMatrices& matrices,
                        Form (*form)(const PointCoefficients&, double, double)) {
  const PointCoefficients coefficients = point_coefficients(matrices);
  Image<Form> table(pixels.size());
  std::transform(pixels.begin(), pixels.end(), table.begin(),
                 [&](const PixelPosition& pixel) { return form(coefficients, pixel.x, pixel.y); });
  return table;
}

/// Equivalent methods to compute a point from a pixel and a projector coordinate.
enum class PointMethod {
  inverse,  ///< Eq. (1.15), inverting a matrix for each point
  form1,    ///< Eqs. (2.21)-(2.24)
  form3,    ///< Eqs. (2.29)-(2.31)
};

/// Converts a camera pixel and decoded projector coordinate to a 3-D point. Corrects both lenses:
/// the table includes the camera's distortion; the projector's depends on the point's position
/// along the stripe and is solved for each point, to rounding. The phase itself is never resampled.
class Triangulator {
 public:
  /// Builds the table for every camera pixel. Throws Error for a scanner that is invalid or gives
  /// no depth along `axis`.
  Triangulator(const Scanner& scanner, Axis axis, PointMethod method);

  [[nodiscard]] const Scanner& scanner() const { return scanner_; }
  [[nodiscard]] Axis axis() const { return axis_; }

  /// Point in the camera's frame, mm, for the pixel and the projector coordinate y, [0, 1), as
  /// decoded. NaN if the ray does not meet the plane or the lens model is not invertible.
  [[nodiscard]] Eigen::Vector3d operator()(int column, int row, double y) const;

 private:
  template <class PointOf>
  Eigen::Vector3d through_projector_lens(const PointOf& point_of, double y) const;

  Scanner scanner_;
  Axis axis_;
  ProjectionMatrices matrices_;
  std::variant<Image<PixelPosition>, Image<PointForm1>, Image<PointForm3>> table_;
};

}  // namespace slipstream
