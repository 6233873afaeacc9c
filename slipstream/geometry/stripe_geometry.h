#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "slipstream/codes/pattern_set.h"
#include "slipstream/geometry/scanner.h"

namespace slipstream {

/// Row k: the coefficients of the Chebyshev polynomial T_k in ascending powers, k < count.
template <int count>
Eigen::Matrix<double, count, count> chebyshev_coefficients() {
  Eigen::Matrix<double, count, count> T = Eigen::Matrix<double, count, count>::Zero();
  T(0, 0) = T(1, 1) = 1;
  for (int k = 2; k < count; ++k) {
    T.row(k).tail(count - 1) = 2 * T.row(k - 1).head(count - 1);
    T.row(k) -= T.row(k - 2);
  }
  return T;
}

/// A polynomial in two variables, sum of c_ij p^i q^j with i + j <= degree.
struct PlanePolynomial {
  int degree = 0;
  std::vector<double> coefficients{0};  ///< c_00 c_01 ... c_0d c_10 ... c_d0

  /// `Number`: double, or an array of Eigen.
  template <class Number>
  [[nodiscard]] Number operator()(const Number& p, const Number& q) const {
    Number sum = p - p;
    auto c = coefficients.rbegin();
    for (int i = degree; i >= 0; --i) {
      Number inner = q - q;
      for (int j = degree - i; j >= 0; --j) inner = inner * q + *c++;
      sum = sum * p + inner;
    }
    return sum;
  }
};

/// An interval mapped to [-1, 1].
struct UnitMap {
  double scale = 1;
  double offset = 0;

  static UnitMap of(double low, double high) {
    return {2 / (high - low), (high + low) / (low - high)};
  }
  [[nodiscard]] double operator()(double value) const { return scale * value + offset; }
  [[nodiscard]] double inverse(double unit) const { return (unit - offset) / scale; }
};

/// How far past either end of the field a coordinate y may lie and be taken for one of it: two
/// hundredths, or half a pixel where that is more. `length`: of the projector along y, pixels.
[[nodiscard]] constexpr double farthest_past_field(double length) {
  return std::max(0.02, 0.5 / length);
}

/// Depth along a camera ray from the projector coordinate, with no table but the rays: M_z, N_z and
/// C of Liu 2010, Eq. (2.29), are ratios of linear functions of the ray e = (E_x, E_y, 1).
///
/// Projector distortion: the points of a ray lie on one line of the projector's undistorted
/// picture, the epipolar line. Where that passes the decoded coordinate y, it has the place x_p
/// along the stripe; y and x_p together tell the line, so that what the lens adds to y is a smooth
/// function of both, here a polynomial. Nothing is iterated.
struct StripeGeometry {
  Eigen::RowVector4d coordinate;  ///< m^p of the coordinate, as in ProjectionMatrices
  Eigen::RowVector4d depth;       ///< m^p of the depth
  /// q, the place x_p mapped to [-1, 1], is (place_constant e + p place_slope e) / (facing e), p
  /// the coordinate y so mapped.
  Eigen::RowVector3d place_constant;
  Eigen::RowVector3d place_slope;
  /// Has the sign of the depth's denominator where the point is in front of the projector.
  Eigen::RowVector3d facing;

  double least_coordinate = 0;  ///< the coordinates y for which the rest holds
  double largest_coordinate = 1;
  UnitMap unit_coordinate;  ///< from y to p
  PlanePolynomial lens;     ///< undistorted coordinate minus decoded one, of (p, q)
  static constexpr int edge_terms = 6;
  std::array<double, edge_terms> low_edge{};   ///< q where the field and its margin end along the
  std::array<double, edge_terms> high_edge{};  ///< stripe, as polynomials in p

  /// The places q that are in the field and its margin at the coordinate p: from, to.
  [[nodiscard]] std::pair<double, double> places_at(double p) const;
  /// Those that are whatever the coordinate.
  [[nodiscard]] std::pair<double, double> inner_places() const;

  struct Depth {
    double z = 0;                   ///< mm; not finite or not positive where there is none
    bool before_projector = false;  ///< else behind it
    bool in_field = false;          ///< and within the margin, along the stripe
  };
  /// Of the point on the ray that the projector lights at the coordinate y, as decoded.
  [[nodiscard]] Depth operator()(double E_x, double E_y, double y) const;
};

/// `margin`: how far past the ends of the field points may lie, see ReconstructSettings. None where
/// the lens is not smooth enough to be described to 4e-7 of the field, or its model has no inverse
/// in the field. Throws Error as Triangulator does.
std::optional<StripeGeometry> stripe_geometry(const Scanner& scanner, Axis axis, double margin);

}  // namespace slipstream
