#include "geometry/ray_blocks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <optional>
#include <tuple>

#include <Eigen/LU>

#include "base/parallel_rows.h"
#include "geometry/ray_table.h"
#include "geometry/stripe_geometry.h"

namespace slipstream {
namespace {

constexpr double coordinate_tolerance = 4e-7;  // of the field
constexpr double ray_tolerance = 1e-7;
/// Limit for the cubic term of a ray's direction: the next one is less than a tenth of it.
constexpr double largest_ray_twist = 1e-6;
/// Margins for limits that are interpolated linearly between nodes: as fractions of the range of
/// 1/Z over the field, and of half the field's width.
constexpr double depth_margin = 0.02, field_margin = 1.5e-3;
constexpr int nodes = 10;        // of the coordinate
constexpr int column_nodes = 4;  // of a block's columns
/// The outermost ones are at the block's edges, so that a condition at both holds in between.
constexpr std::array<int, column_nodes> node_columns{0, 10, 21, 31};

using Block = RayBlocks::Block;

/// Rows: nodes or powers of p, columns: nodes or powers of t.
using NodeArray = Eigen::Array<double, nodes, 1>;
/// The nodes and both ends of the field.
constexpr int places = nodes + 2;
using PlaceArray = Eigen::Array<double, places, 1>;
using Samples = Eigen::Matrix<double, nodes, column_nodes>;

/// Values of T_0 ... at x.
template <int count>
Eigen::Matrix<double, 1, count> chebyshev_polynomials(double x) {
  // T_k = 2 x T_(k-1) - T_(k-2).
  Eigen::Matrix<double, 1, count> T;
  T(0) = 1;
  T(1) = x;
  for (int k = 2; k < count; ++k) T(k) = 2 * x * T(k - 1) - T(k - 2);
  return T;
}

/// Data shared by all blocks.
struct Fit {
  NodeArray p, y;
  PlaceArray places_p, low_edge, high_edge;

  Eigen::Matrix<double, nodes, nodes> spectrum;              ///< from values at p
  Eigen::Matrix<double, 2, nodes> ends;                      ///< at 1 and -1 from those at p
  Eigen::Matrix<double, column_nodes, column_nodes> across;  ///< from values at t, transposed
  Eigen::Matrix<double, nodes, nodes> powers = chebyshev_coefficients<nodes>();
  Eigen::Matrix<double, column_nodes, column_nodes> across_powers =
      chebyshev_coefficients<column_nodes>();

  explicit Fit(const StripeGeometry& geometry) {
    // 1. The nodes in the coordinate, and the transform from values there to a spectrum.
    Eigen::Matrix<double, nodes, nodes> at_p;
    for (int i = 0; i < nodes; ++i) {
      p(i) = std::cos(std::numbers::pi * (i + 0.5) / nodes);
      y(i) = geometry.unit_coordinate.inverse(p(i));
      at_p.row(i) = chebyshev_polynomials<nodes>(p(i));
    }
    spectrum = at_p.inverse();
    ends << chebyshev_polynomials<nodes>(1) * spectrum, chebyshev_polynomials<nodes>(-1) * spectrum;

    // 2. The edges of the field at the nodes and both ends.
    places_p << 1, p, -1;
    for (int i = 0; i < places; ++i) {
      std::tie(low_edge(i), high_edge(i)) = geometry.places_at(places_p(i));
    }

    // 3. The transform along a block's columns; t is 1 at half a block's width from the middle.
    Eigen::Matrix<double, column_nodes, column_nodes> at_t;
    for (int i = 0; i < column_nodes; ++i) {
      const double from_middle = node_columns[i] - 0.5 * (RayBlocks::width - 1);
      at_t.row(i) = chebyshev_polynomials<column_nodes>(from_middle / (0.5 * RayBlocks::width));
    }
    across = at_t.inverse().transpose();
  }
};

/// Number of powers of p used for each power of t.
constexpr std::array<int, column_nodes> terms{RayBlocks::constants, RayBlocks::slopes,
                                              RayBlocks::bends, RayBlocks::twists};

RayBlocks::Range intersection(const RayBlocks::Range& a, const RayBlocks::Range& b) {
  return {std::max(a.least, b.least), std::min(a.largest, b.largest)};
}

/// The range of p where the values exceed the margin, linear between places.
RayBlocks::Range range_above(double margin, const PlaceArray& values, const PlaceArray& p) {
  const PlaceArray above = values - margin;

  // Where the line between two neighbouring places crosses the margin.
  const auto crossing = [&](int inside, int outside) {
    const double share = above(inside) / (above(inside) - above(outside));
    return static_cast<float>(std::lerp(p(inside), p(outside), share));
  };

  // The first run of places above the margin; they are in descending order of p.
  int first = 0;
  while (first < places && !(above(first) > 0)) ++first;
  if (first == places) return {};
  int last = first;
  while (last + 1 < places && above(last + 1) > 0) ++last;

  return {last + 1 == places ? -1.0F : crossing(last, last + 1),
          first == 0 ? 1.0F : crossing(first, first - 1)};
}

/// Further data of a block at a knot.
struct KnownBlock {
  bool is_fitted = false;
  double tolerance = 0;  ///< tolerated error of 1/Z
  RayBlocks::Range described{};
};

/// The blocks of one row of knots.
struct KnotRow {
  const StripeGeometry& geometry;
  const Fit& fit;
  const RayTable& rays;
  int row;

  /// Fills the block and returns its `described` range for this row.
  KnownBlock fill(int first_column, Block& block) const {
    // 1. 1/Z at the nodes, and the range of it over the block.
    Samples inverse_depth;
    double smallest = INFINITY, largest = -INFINITY;
    for (int i = 0; i < column_nodes; ++i) {
      const auto at = inverse_depth_at(first_column + node_columns[i]);
      inverse_depth.col(i) = at;
      smallest = std::min(smallest, at.minCoeff());
      largest = std::max(largest, at.maxCoeff());
    }

    // 2. The polynomials, with 1/Z as exact as the tolerance of the coordinate requires.
    const double length = fit.y.maxCoeff() - fit.y.minCoeff();
    const double tolerance = coordinate_tolerance * (largest - smallest) / length;
    const bool described = fill_inverse_depth(inverse_depth, tolerance, block) &&
                           fill_ray(rays.E_x, first_column, Block::E_x, block) &&
                           fill_ray(rays.E_y, first_column, Block::E_y, block);
    if (!described) return {};

    // 3. The range of p with a point in the field on every ray: depths at the columns of the
    //    nodes, places along the stripe at both outer columns.
    PlaceArray least_depth;
    const Eigen::Array<double, 2, 1> at_ends = (fit.ends * inverse_depth).rowwise().minCoeff();
    least_depth << at_ends(0), inverse_depth.rowwise().minCoeff(), at_ends(1);

    const PlaceArray least_inside =
        inside_field(first_column).min(inside_field(first_column + RayBlocks::width - 1));

    return {
        true, tolerance,
        intersection(range_above(depth_margin * (largest - smallest), least_depth, fit.places_p),
                     range_above(field_margin, least_inside, fit.places_p))};
  }

  [[nodiscard]] Eigen::Vector3d ray(int column) const {
    return {rays.E_x(column, row), rays.E_y(column, row), 1};
  }

  /// NaN if its sign does not determine whether there is a point.
  [[nodiscard]] Eigen::Matrix<double, nodes, 1> inverse_depth_at(int column) const {
    // Places along the stripe, and undistorted coordinates w on the epipolar line.
    const Eigen::Vector3d e = ray(column);
    const double g = geometry.facing * e;
    const NodeArray q = (geometry.place_constant.dot(e) + fit.p * geometry.place_slope.dot(e)) / g;
    const NodeArray w = fit.y + geometry.lens(fit.p, q);

    // 1/Z = (A e - w D e) / (w D4 - A4), with the rows A of the coordinate and D of the depth.
    const NodeArray numerator = w * geometry.depth(3) - geometry.coordinate(3);
    if (!((numerator * g).minCoeff() > 0)) return Eigen::Matrix<double, nodes, 1>::Constant(NAN);
    return (geometry.coordinate.head<3>().dot(e) - w * geometry.depth.head<3>().dot(e)) / numerator;
  }

  [[nodiscard]] bool fill_inverse_depth(const Samples& samples, double tolerance,
                                        Block& block) const {
    // Drop the small terms of the spectrum, if their sum is within the tolerance.
    Samples spectrum = fit.spectrum * samples * fit.across;
    double left_out = 0;
    for (int m = 0; m < column_nodes; ++m) {
      left_out += spectrum.col(m).tail(nodes - terms[m]).lpNorm<1>();
      spectrum.col(m).tail(nodes - terms[m]).setZero();
    }
    if (!(left_out <= tolerance)) return false;

    // The rest as powers of p, for each power of t.
    const Samples monomials = fit.powers.transpose() * spectrum * fit.across_powers;
    auto c = block.coefficients.begin();
    for (int m = 0; m < column_nodes; ++m) {
      for (int k = 0; k < terms[m]; ++k) *c++ = static_cast<float>(monomials(k, m));
    }

    return true;
  }

  bool fill_ray(const Image<float>& E, int first_column, int place, Block& block) const {
    Eigen::Matrix<double, 1, column_nodes> samples;
    for (int i = 0; i < column_nodes; ++i) samples(i) = E(first_column + node_columns[i], row);

    const Eigen::Matrix<double, 1, column_nodes> spectrum = samples * fit.across;
    if (!(std::abs(spectrum(3)) <= largest_ray_twist)) return false;

    const Eigen::Matrix<double, 1, column_nodes> monomials = spectrum * fit.across_powers;

    static_assert(RayBlocks::ray_terms == column_nodes);
    for (int m = 0; m < RayBlocks::ray_terms; ++m) {
      block.coefficients[place + m] = static_cast<float>(monomials(m));
    }

    return true;
  }

  /// Distance of q, which is linear in p, to the nearer edge of the field.
  [[nodiscard]] PlaceArray inside_field(int column) const {
    const Eigen::Vector3d e = ray(column);
    const PlaceArray q =
        (geometry.place_constant.dot(e) + fit.places_p * geometry.place_slope.dot(e)) /
        (geometry.facing * e);
    return (q - fit.low_edge).min(fit.high_edge - q);
  }
};

/// Whether a quadratic through three knots agrees with the cubic through four.
bool is_quadratic(const std::array<const Block*, 4>& b, double inverse_depth_tolerance) {
  constexpr double share = 0.0642;  // of the third difference, at most

  // An upper bound, as no power of p or t exceeds 1.
  const auto missed = [&](int first, int last) {
    double sum = 0;
    for (int i = first; i < last; ++i) {
      const auto c = [&](std::size_t k) { return double{b[k]->coefficients[i]}; };
      sum += share * std::abs(c(3) - 3 * c(2) + 3 * c(1) - c(0));
    }
    return sum;
  };

  return missed(0, Block::E_x) <= inverse_depth_tolerance &&
         missed(Block::E_x, Block::E_y) <= ray_tolerance &&
         missed(Block::E_y, Block::E_y + RayBlocks::ray_terms) <= ray_tolerance;
}

}  // namespace

RayBlocks::Row RayBlocks::at(int row) const {
  // The row's knot and the next two, or the last three.
  const int first = std::min(row / spacing, knots.height() - 3);

  Row blocks;
  for (int k = 0; k < 3; ++k) {
    // Lagrange's weights of a parabola through three knots.
    double weight = 1;
    for (int other = 0; other < 3; ++other) {
      const int place = knot_rows[first + other];
      if (other == k) continue;
      weight *= static_cast<double>(row - place) / (knot_rows[first + k] - place);
    }

    blocks.knots[k] = knots.row(first + k);
    blocks.weights[k] = static_cast<float>(weight);
  }

  blocks.described = described.row(first);
  return blocks;
}

std::optional<RayBlocks> ray_blocks(const StripeGeometry& geometry, const RayTable& rays) {
  const Size size = rays.E_x.size();
  const int across = (size.width + RayBlocks::width - 1) / RayBlocks::width;

  // 1. The knots: every eighth row, and the last one.
  RayBlocks blocks;
  for (int row = 0; row < size.height - 1; row += RayBlocks::spacing) {
    blocks.knot_rows.push_back(row);
  }
  blocks.knot_rows.push_back(size.height - 1);
  const auto down = static_cast<int>(blocks.knot_rows.size());

  if (geometry.solved || size.width < RayBlocks::width || down < 5) return std::nullopt;

  // 2. Fit the blocks at the knots.
  blocks.knots = Image<Block>({across, down});
  blocks.described = Image<RayBlocks::Range>({across, down});
  Image<KnownBlock> known({across, down});

  const Fit fit(geometry);
  for_each_row(down, [&](int k) {
    const KnotRow row{geometry, fit, rays, blocks.knot_rows[k]};
    for (int i = 0; i < across; ++i) {
      known(i, k) = row.fill(RayBlocks::first_column(i, size.width), blocks.knots(i, k));
    }
  });

  // 3. Where rows between knots can be interpolated: the range is common to all knots involved.
  for (int k = 0; k < down - 2; ++k) {
    // The last knot is nearer to its neighbour than the others: use the four before it.
    const int first = std::clamp(k, 0, down - 5);
    for (int i = 0; i < across; ++i) {
      const bool smooth = is_quadratic({&blocks.knots(i, first), &blocks.knots(i, first + 1),
                                        &blocks.knots(i, first + 2), &blocks.knots(i, first + 3)},
                                       known(i, k).tolerance);
      if (!smooth || !known(i, k + 2).is_fitted) continue;

      // The last entry also covers the rows up to the last knot.
      const int end = k == down - 3 ? k + 2 : k + 1;

      blocks.described(i, k) = known(i, k).described;
      for (int next = k + 1; next <= end; ++next) {
        blocks.described(i, k) = intersection(blocks.described(i, k), known(i, next).described);
      }
    }
  }

  return blocks;
}

}  // namespace slipstream
