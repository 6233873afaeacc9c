#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "slipstream/geometry/scanner.h"

namespace slipstream {

/// E_x, E_y of Liu 2010, Eqs. (2.30), (2.31), in the camera's own frame, where F_x = F_y = 0: the
/// ray through each pixel is (E_x, E_y, 1) Z. Camera distortion included. The third form's other
/// tables are functions of these two and of constants: see StripeGeometry.
struct RayTable {
  Image<float> E_x, E_y;
};

/// Exact at every eighth pixel and cubic between, a few milliseconds for 640x480; exact everywhere
/// where the cubic would miss a ray by more than 1e-7, as in small pictures. None where some pixel
/// has no ray.
std::optional<RayTable> ray_table(const Lens& camera);

/// StripeGeometry and RayTable as polynomials, one set for each block of neighbouring pixels of a
/// row. Their variables are t, the column counted from the block's middle in half widths of a
/// block, and p, the projector coordinate mapped to [-1, 1]:
///   1/Z = sum c_k p^k + t sum d_k p^k + t^2 sum e_k p^k + t^3 f, projector lens included;
///   E_x and E_y are cubics in t.
/// The coefficients are kept at every eighth row, the knots, and are interpolated between them by a
/// quadratic through three knots.
struct RayBlocks {
  static constexpr int width = 32;  ///< pixels of a block; a row's last one may overlap another
  static constexpr int spacing = 8;
  static constexpr int constants = 9, slopes = 7, bends = 4, twists = 1;  ///< terms c, d, e, f
  static constexpr int ray_terms = 4;

  /// The coefficients c, d, e, f, then those of E_x and of E_y; the rest is padding.
  struct alignas(64) Block {
    static constexpr int E_x = constants + slopes + bends + twists, E_y = E_x + ray_terms;
    std::array<float, 32> coefficients{};
  };

  Image<Block> knots;          ///< column: the block, row: the knot
  std::vector<int> knot_rows;  ///< the row of pixels that each knot stands for

  /// A range of p; the default is empty.
  struct Range {
    float least = 1, largest = -1;
  };
  /// For each block and knot: the range of p in which the polynomials, interpolated from this knot
  /// and the two after it, hold for all rows to the next knot, or from the third knot from the end
  /// to the last row. Every ray of the block has a point there, in the field or its margin.
  Image<Range> described;

  /// What gives the blocks of one row of pixels: each is the sum of `weights` times the blocks at
  /// `knots`, and holds within its range `described`.
  struct Row {
    std::array<const Block*, 3> knots{};
    std::array<float, 3> weights{};
    const Range* described = nullptr;
  };
  [[nodiscard]] Row at(int row) const;

  /// The first pixel of block `i` in rows of `row_width` pixels.
  static constexpr int first_column(int i, int row_width) {
    return std::min(i * width, row_width - width);
  }
};

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
  double scale = 1, offset = 0;

  static UnitMap of(double low, double high) {
    return {2 / (high - low), (high + low) / (low - high)};
  }
  [[nodiscard]] double operator()(double value) const { return scale * value + offset; }
  [[nodiscard]] double inverse(double unit) const { return (unit - offset) / scale; }
};

/// How far past either end of the field a coordinate y may lie: two hundredths, or half a pixel if
/// more. `length`: of the projector along y, pixels.
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
  Eigen::RowVector3d place_constant, place_slope;
  /// Has the sign of the depth's denominator where the point is in front of the projector.
  Eigen::RowVector3d facing;

  double least_coordinate = 0, largest_coordinate = 1;  ///< the y for which the rest holds
  UnitMap unit_coordinate;                              ///< from y to p
  PlanePolynomial lens;  ///< undistorted coordinate minus decoded one, of (p, q)
  static constexpr int edge_terms = 6;
  /// q where the field and its margin end along the stripe, as polynomials in p.
  std::array<double, edge_terms> low_edge{}, high_edge{};

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
/// the lens cannot be described to 4e-7 of the field, or its model has no inverse there. Throws
/// Error as Triangulator does.
std::optional<StripeGeometry> stripe_geometry(const Scanner& scanner, Axis axis, double margin);

/// The blocks of a picture. Within the range `described` depths are those of coordinates at most
/// 1e-6 of the field away, and E_x, E_y are right to 2.5e-7. None for pictures less than a block
/// wide or five knots high.
std::optional<RayBlocks> ray_blocks(const StripeGeometry& geometry, const RayTable& rays);

}  // namespace slipstream
