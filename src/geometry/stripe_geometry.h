#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include "slipstream/scanner.h"

namespace slipstream {

/// Row k: the coefficients of the Chebyshev polynomial T_k in ascending powers, k < count.
template <int count>
Eigen::Matrix<double, count, count> chebyshev_coefficients() {
  Eigen::Matrix<double, count, count> T = Eigen::Matrix<double, count, count>::Zero();
  T(0, 0) = T(1, 1) = 1;

  // T_k = 2 x T_(k-1) - T_(k-2).
  for (int k = 2; k < count; ++k) {
    T.row(k).tail(count - 1) = 2 * T.row(k - 1).head(count - 1);
    T.row(k) -= T.row(k - 2);
  }

  return T;
}

/// From values at the nodes cos(pi (i + 1/2) / count) to Chebyshev coefficients.
template <int count>
Eigen::Matrix<double, count, count> chebyshev_transform() {
  Eigen::Matrix<double, count, count> transform;
  for_each_pixel_in_order({count, count}, [&](int i, int k) {
    transform(k, i) =
        (k == 0 ? 1.0 : 2.0) / count * std::cos(std::numbers::pi * k * (i + 0.5) / count);
  });
  return transform;
}

/// A polynomial in two variables, sum of c_ij p^i q^j with i + j <= degree.
struct PlanePolynomial {
  static constexpr int largest_degree = 8;

  int degree = 0;
  std::vector<double> coefficients{0};  ///< c_00 c_01 ... c_0d c_10 ... c_d0

  /// `Number`: double, or an Eigen array.
  template <class Number>
  [[nodiscard]] Number operator()(const Number& p, const Number& q) const {
    // Horner's scheme in q within p. p - p is 0 in the operands' shape: an Eigen array has no plain
    // 0.
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
  double scale = 1, offset = 0;

  static UnitMap of(double low, double high) {
    return {2 / (high - low), (high + low) / (low - high)};
  }

  [[nodiscard]] double operator()(double value) const { return scale * value + offset; }
  [[nodiscard]] double inverse(double unit) const { return (unit - offset) / scale; }
};

/// How far beyond the ends of the field a coordinate y may lie: two hundredths, or half a pixel if
/// more. `length`: of the projector along y, pixels.
[[nodiscard]] constexpr double farthest_past_field(double length) {
  return std::max(0.02, 0.5 / length);
}

/// The projector's lens, for Newton's method. A direction is (a, b, 1), along and across the axis.
struct SolvedLens {
  static constexpr int start_degree = 7;  ///< of StripeGeometry::lens, at most

  /// (a, b) of (w, q, 1): on the epipolar line, q changes with the undistorted coordinate w.
  Eigen::Matrix<float, 2, 3> direction;

  /// k1 k2 k3 k4 k5 k6 t_a t_b u_a v_a u_b v_b: with r^2 = a^2 + b^2 and the quotient R as in
  /// distort_untilted, a bends to a (R + t_a a + t_b b) + r^2 (u_a + v_a r^2), and b in the same
  /// way.
  Eigen::Matrix<float, 12, 1> bend;

  /// From the bent direction to multiples of (y, place, 1); |place| <= 1 in the field and its
  /// margin.
  Eigen::Matrix3f image;
  float largest_square = 0;  ///< of r in the field; beyond it, the model may turn back
};

/// Depth along a camera ray from the projector coordinate, with no table but the rays: M_z, N_z and
/// C of Liu 2010, Eq. (2.29), are ratios of linear functions of the ray e = (E_x, E_y, 1).
///
/// Projector distortion: the points of a ray lie on one line of the undistorted projector image,
/// the epipolar line. Where it crosses the decoded coordinate y, its position along the stripe is
/// x_p; y and x_p together determine the line, so that the lens's change of y is a smooth function
/// of both, here a polynomial. No iteration is required if one describes it.
struct StripeGeometry {
  Eigen::RowVector4d coordinate;  ///< m^p of the coordinate, as in ProjectionMatrices
  Eigen::RowVector4d depth;       ///< m^p of the depth

  /// q, the position x_p mapped to [-1, 1], is (place_constant e + p place_slope e) / (facing e),
  /// where p is y mapped to [-1, 1].
  Eigen::RowVector3d place_constant, place_slope;
  /// Has the sign of the depth's denominator if the point is in front of the projector.
  Eigen::RowVector3d facing;

  double least_coordinate = 0, largest_coordinate = 1;  ///< range of y for which the rest is valid
  UnitMap unit_coordinate;                              ///< from y to p

  PlanePolynomial lens;  ///< undistorted minus decoded coordinate, of (p, q)

  static constexpr int edge_terms = 6;
  /// q at the ends of the field and its margin along the stripe, as polynomials in p.
  std::array<double, edge_terms> low_edge{}, high_edge{};

  /// For a lens that no polynomial describes: `lens` is where Newton's method starts, and the edges
  /// are not used.
  std::optional<SolvedLens> solved{};

  /// Range of q inside the field and its margin at the coordinate p.
  [[nodiscard]] std::pair<double, double> places_at(double p) const;
  /// Range of q that is inside at every coordinate.
  [[nodiscard]] std::pair<double, double> inner_places() const;
};

/// `margin`: how far beyond the ends of the field points may lie, see ReconstructSettings. The lens
/// is solved if polynomials do not fit it to 4e-7 of the field. nullopt if its model cannot be
/// inverted over the projector's picture. Throws Error as Triangulator does.
std::optional<StripeGeometry> stripe_geometry(const Scanner& scanner, Axis axis, double margin);

}  // namespace slipstream
