#pragma once

#include <algorithm>

#include <Eigen/Core>

#include "slipstream/base/image.h"
#include "slipstream/geometry/lens.h"
#include "slipstream/geometry/projection_matrices.h"

namespace slipstream {

/// A linear function of the camera pixel, p_1 x^c + p_2 y^c + p_3, for each of X, Y, Z and the
/// homogeneous coordinate: the columns are (p_x p_y p_z p_w).
using PixelPolynomial = Eigen::Matrix<double, 4, 3>;

/// The coefficients of Liu 2010, Section 2.1, under Eq. (2.24): the numerators and denominators of
/// Eq. (1.15) as linear functions of the camera pixel. `with_coordinate` holds a_x, a_y, a_z and c,
/// which are multiplied by y^p, `constant` b_x, b_y, b_z and d.
struct PointCoefficients {
  PixelPolynomial with_coordinate;
  PixelPolynomial constant;
  Eigen::Matrix<double, 3, 4> camera;  ///< M^c, of which E and F of the third form are made
};

PointCoefficients point_coefficients(const ProjectionMatrices& matrices);

/// First form, Eqs. (2.21)-(2.24): 7 multiplications, 1 division, 4 additions.
struct PointForm1 {
  double A_x, B_x, A_y, B_y, A_z, B_z, C;
  [[nodiscard]] Eigen::Vector3d operator()(double y_p) const;
};

/// Second form, Eqs. (2.25)-(2.28): 4 multiplications, 1 division, 4 additions.
struct PointForm2 {
  double M_x, N_x, M_y, N_y, M_z, N_z, C;
  [[nodiscard]] Eigen::Vector3d operator()(double y_p) const;
};

/// Third form, Eqs. (2.29)-(2.31): 3 multiplications, 1 division, 4 additions.
struct PointForm3 {
  double M_z, N_z, C, E_x, F_x, E_y, F_y;
  [[nodiscard]] Eigen::Vector3d operator()(double y_p) const;
};

/// The entries of the tables at undistorted camera pixel (x, y). The points they give are those of
/// Eq. (1.15). The second and third form have none, and give NaN, at a pixel whose ray is
/// perpendicular to the projector's optical axis (C = 0).
PointForm1 point_form1(const PointCoefficients& coefficients, double x, double y);
PointForm2 point_form2(const PointCoefficients& coefficients, double x, double y);
PointForm3 point_form3(const PointCoefficients& coefficients, double x, double y);

/// A form for each undistorted pixel, by the function above that makes it.
template <class Form>
Image<Form> point_table(const Image<PixelPosition>& pixels, const ProjectionMatrices& matrices,
                        Form (*form)(const PointCoefficients&, double, double)) {
  const PointCoefficients coefficients = point_coefficients(matrices);
  Image<Form> table(pixels.size());
  std::transform(pixels.begin(), pixels.end(), table.begin(),
                 [&](const PixelPosition& pixel) { return form(coefficients, pixel.x, pixel.y); });
  return table;
}

}  // namespace slipstream
