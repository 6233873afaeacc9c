#include "geometry/stripe_geometry.h"

#include <array>
#include <optional>

#include <Eigen/Geometry>
#include <Eigen/LU>

#include "base/numbers.h"
#include "geometry/triangulator.h"

namespace slipstream {
namespace {

constexpr int fitted_nodes = 16;
constexpr double lens_tolerance = 4e-7;  ///< of the field
constexpr double start_tolerance = 1;    ///< of the field, summed over the terms left out
constexpr double edge_tolerance = 1e-4;  ///< of the field: only decides which points are outside

using StripeSamples = Eigen::Matrix<double, fitted_nodes, fitted_nodes>;  ///< rows: p, columns: q
using NodeSamples = Eigen::Matrix<double, fitted_nodes, 1>;

double node(int i) {
  return std::cos(std::numbers::pi * (i + 0.5) / fitted_nodes);
}

/// The projector's image plane: coordinates along and across the axis, both in lengths of the
/// field, w for undistorted and y for distorted ones.
class ProjectorPlane {
 public:
  ProjectorPlane(const Scanner& scanner, Axis axis)
      : lens_(scanner.projector), along_(axis == Axis::x ? 0 : 1) {
    rows_ = projection_matrices(scanner, axis);
    across_row_ = projection_matrices(scanner, slipstream::across(axis)).projector_coordinate;
    inverse_intrinsic_ = lens_.intrinsic.inverse();
  }

  [[nodiscard]] Eigen::RowVector4d along() const { return rows_.projector_coordinate; }
  [[nodiscard]] Eigen::RowVector4d across() const { return across_row_; }
  [[nodiscard]] Eigen::RowVector4d depth() const { return rows_.projector_depth; }
  [[nodiscard]] double along_length() const { return size(along_); }
  [[nodiscard]] double across_length() const { return size(1 - along_); }

  /// Both convert (along, across).
  [[nodiscard]] Eigen::Vector2d distorted(const Eigen::Vector2d& w) const {
    const Eigen::Vector3d direction = inverse_intrinsic_ * pixel_at(w).homogeneous();
    return place_of(project(lens_, direction));
  }
  [[nodiscard]] Eigen::Vector2d undistorted(const Eigen::Vector2d& y) const {
    const Eigen::Vector3d pixel = lens_.intrinsic * ray_through(lens_, pixel_at(y));
    return place_of(pixel.head<2>());
  }

  /// `unit_place`: from the place across to q. Nullopt if the model is not invertible, or has a
  /// residual.
  [[nodiscard]] std::optional<SolvedLens> solved(const UnitMap& unit_place, double end,
                                                 double margin) const {
    if (!lens_.residual.terms.empty()) return std::nullopt;

    // 1. How far from the axis rays may lie: the lens must be invertible over the field and its
    //    margin.
    const int a = along_, b = 1 - along_;
    Eigen::Vector2d margins(margin, margin);
    margins(a) = end;
    const std::optional<double> largest = largest_tangent(lens_, margins);
    if (!largest) return std::nullopt;

    // 2. From (w, q, 1) to the undistorted pixel, and on to the direction.
    const auto& k = lens_.distortion.coefficients;
    Eigen::Matrix3d pixel = Eigen::Matrix3d::Zero();  // of (w, q, 1)
    pixel(a, 0) = along_length();
    pixel(b, 1) = across_length() / unit_place.scale;
    pixel(b, 2) = across_length() * unit_place.inverse(0);
    pixel(2, 2) = 1;
    const Eigen::Matrix3d direction = inverse_intrinsic_ * pixel;

    // 3. The coefficients of the lens, with a along the axis and b across it. Component 0 of
    //    OpenCV's tangential terms has p2 = k[3] where component 1 has p1 = k[2].
    Eigen::Matrix<double, 12, 1> bend;
    bend << k[0], k[1], k[4], k[5], k[6], k[7], 2 * k[3 - a], 2 * k[2 + a],  //
        k[3 - a] + k[8 + 2 * a], k[9 + 2 * a], k[2 + a] + k[8 + 2 * b], k[9 + 2 * b];

    // 4. From the bent direction to coordinate and place: rows in shares of the field; the place is
    //    -1 to 1 over the field with its margin.
    Eigen::Matrix3d image = lens_.intrinsic * sensor_tilt(k[12], k[13]);
    if (a == 1) image = image({1, 0, 2}, {1, 0, 2}).eval();
    image.row(0) /= along_length();
    image.row(1) = (2 / across_length() * image.row(1) - image.row(2)) / (1 + 2 * margin);

    return SolvedLens{direction({a, b}, {0, 1, 2}).cast<float>(), bend.cast<float>(),
                      image.cast<float>(), static_cast<float>(*largest * *largest)};
  }

  /// d across / d along of the epipolar line through w.
  [[nodiscard]] double slope_through(const Eigen::Vector2d& w) const {
    const double A = along()(3), B = across()(3), D = depth()(3);
    return (B - w.y() * D) / (A - w.x() * D);
  }

  /// The coordinate on the epipolar line through (y, place) that the lens distorts to y, by the
  /// secant method from `start`, or NaN.
  [[nodiscard]] double undistorted_on_line(double y, double place, double start) const {
    const double slope = slope_through({y, place});
    const auto error = [&](double w) { return distorted({w, place + slope * (w - y)}).x() - y; };

    double before = start, error_before = error(before), now = before - error_before;
    for (int iteration = 0; iteration < 40; ++iteration) {
      const double error_now = error(now);
      if (std::abs(error_now) < 1e-13) return now;

      const double step = error_now * (now - before) / (error_now - error_before);
      before = now;
      error_before = error_now;
      now -= step;
    }

    return nan;
  }

 private:
  [[nodiscard]] double size(int direction) const {
    return direction == 0 ? lens_.size.width : lens_.size.height;
  }

  [[nodiscard]] Eigen::Vector2d pixel_at(const Eigen::Vector2d& place) const {
    Eigen::Vector2d pixel;
    pixel(along_) = place.x() * along_length();
    pixel(1 - along_) = place.y() * across_length();
    return pixel;
  }

  [[nodiscard]] Eigen::Vector2d place_of(const Eigen::Vector2d& pixel) const {
    return {pixel(along_) / along_length(), pixel(1 - along_) / across_length()};
  }

  Lens lens_;
  int along_;
  ProjectionMatrices rows_;
  Eigen::RowVector4d across_row_;
  Eigen::Matrix3d inverse_intrinsic_;
};

/// The polynomial of least degree whose omitted terms are within the tolerance.
std::optional<PlanePolynomial> fitted(const StripeSamples& samples, double tolerance,
                                      int largest_degree) {
  if (!samples.allFinite()) return std::nullopt;

  // 1. The terms beyond the largest degree, which cannot be kept, must be within the tolerance.
  const auto transform = chebyshev_transform<fitted_nodes>();
  StripeSamples spectrum = transform * samples * transform.transpose();
  int degree = largest_degree + 1;
  double left_out = 0;
  for_each_pixel_in_order({fitted_nodes, fitted_nodes}, [&](int j, int i) {
    if (i + j >= degree) left_out += std::abs(spectrum(i, j));
  });
  if (!(left_out <= tolerance)) return std::nullopt;

  // 2. Leave out further degrees, from the highest down, as long as their sum stays within it.
  for (; degree > 0; --degree) {
    double next = left_out;
    for (int i = 0; i < degree; ++i) next += std::abs(spectrum(i, degree - 1 - i));
    if (next > tolerance) break;
    left_out = next;
  }
  --degree;  // now the largest degree kept; -1 if all terms are within the tolerance

  for_each_pixel_in_order({fitted_nodes, fitted_nodes}, [&](int j, int i) {
    if (i + j > degree) spectrum(i, j) = 0;
  });

  // 3. From Chebyshev polynomials to powers.
  const auto T = chebyshev_coefficients<fitted_nodes>();
  const StripeSamples monomials = T.transpose() * spectrum * T;

  PlanePolynomial polynomial{std::max(degree, 0), {}};
  for (int i = 0; i <= polynomial.degree; ++i) {
    for (int j = 0; i + j <= polynomial.degree; ++j) {
      polynomial.coefficients.push_back(monomials(i, j));
    }
  }

  return polynomial;
}

/// A polynomial in p of `edge_terms` terms; nullopt if it is inaccurate.
std::optional<std::array<double, StripeGeometry::edge_terms>> fitted_edge(
    const NodeSamples& samples) {
  if (!samples.allFinite()) return std::nullopt;

  constexpr int terms = StripeGeometry::edge_terms;
  NodeSamples spectrum = chebyshev_transform<fitted_nodes>() * samples;
  if (spectrum.tail<fitted_nodes - terms>().lpNorm<1>() > edge_tolerance) return std::nullopt;
  spectrum.tail<fitted_nodes - terms>().setZero();

  const NodeSamples monomials = chebyshev_coefficients<fitted_nodes>().transpose() * spectrum;
  std::array<double, terms> edge{};
  std::copy_n(monomials.data(), terms, edge.begin());

  return edge;
}

double evaluated(const std::array<double, StripeGeometry::edge_terms>& edge, double p) {
  // Horner's scheme.
  double sum = 0;
  for (auto c = edge.rbegin(); c != edge.rend(); ++c) sum = sum * p + *c;
  return sum;
}

/// The point of ray e at the undistorted coordinate y lies at (B4 a - A4 b + y (D4 b - B4 d)) / g
/// along the stripe, with a, b, d, g = A e, B e, D e, D4 a - A4 d, and the rows A of the
/// coordinate, B of the position along the stripe and D of the depth.
void set_place(StripeGeometry& geometry, const ProjectorPlane& plane, const UnitMap& unit_place) {
  const Eigen::RowVector4d A = plane.along(), B = plane.across(), D = plane.depth();
  const Eigen::RowVector3d a = A.head<3>(), b = B.head<3>(), d = D.head<3>();
  const UnitMap& unit = geometry.unit_coordinate;
  geometry.facing = D(3) * a - A(3) * d;

  // Replace y by its unit map p and the place by its unit map q.
  const Eigen::RowVector3d constant = B(3) * a - A(3) * b;
  const Eigen::RowVector3d slope = D(3) * b - B(3) * d;
  geometry.place_slope = unit_place.scale / unit.scale * slope;
  geometry.place_constant = unit_place.scale * constant + unit_place.offset * geometry.facing -
                            unit.offset * geometry.place_slope;
}

/// The ends of the stripes at the nodes of the coordinate.
struct StripeEnds {
  NodeSamples y;  ///< the coordinate
  NodeSamples low, high;

  /// Whether both ends exist, less than three fields apart.
  [[nodiscard]] bool are_usable() const {
    return low.allFinite() && high.allFinite() && high.maxCoeff() - low.minCoeff() < 3;
  }
};

/// The undistorted end of the field, moved along its epipolar line to the coordinate y.
StripeEnds stripe_ends(const ProjectorPlane& plane, const UnitMap& unit_coordinate, double margin) {
  const auto place = [&](double y, double edge) {
    const Eigen::Vector2d w = plane.undistorted({y, edge});
    return w.y() + plane.slope_through(w) * (y - w.x());
  };

  StripeEnds ends;
  for (int i = 0; i < fitted_nodes; ++i) {
    ends.y(i) = unit_coordinate.inverse(node(i));
    ends.low(i) = place(ends.y(i), -margin);
    ends.high(i) = place(ends.y(i), 1 + margin);
  }

  return ends;
}

/// The lens: undistorted minus distorted coordinate at the nodes of (p, q). `inside` keeps to
/// places in the field and starts at the lens's own inverse there.
StripeSamples added_by_lens(const ProjectorPlane& plane, const StripeEnds& ends,
                            const UnitMap& unit_place, bool inside) {
  StripeSamples samples;
  for_each_pixel_in_order({fitted_nodes, fitted_nodes}, [&](int j, int i) {
    const double y = ends.y(i);
    double across = unit_place.inverse(node(j)), start = y;
    if (inside) {
      across = std::clamp(across, ends.low(i), ends.high(i));
      const double near = plane.undistorted({y, across}).x();
      if (std::isfinite(near)) start = near;
    }

    samples(i, j) = plane.undistorted_on_line(y, across, start) - y;
  });

  return samples;
}

}  // namespace

std::pair<double, double> StripeGeometry::places_at(double p) const {
  return {evaluated(low_edge, p), evaluated(high_edge, p)};
}

std::pair<double, double> StripeGeometry::inner_places() const {
  constexpr int samples = 64;
  constexpr double apart = 1e-3;  // more than the edges curve between two samples

  double low = -1, high = 1;
  for (int i = 0; i <= samples; ++i) {
    const auto [least, largest] = places_at(2.0 * i / samples - 1);
    low = std::max(low, least);
    high = std::min(high, largest);
  }

  return {low + apart, high - apart};
}

std::optional<StripeGeometry> stripe_geometry(const Scanner& scanner, Axis axis, double margin) {
  // 1. The projection of points, and the range of the coordinate.
  require_valid(scanner);
  require_depth_visible(scanner, axis);

  const ProjectorPlane plane(scanner, axis);
  StripeGeometry geometry;
  geometry.coordinate = plane.along();
  geometry.depth = plane.depth();

  const double end = farthest_past_field(plane.along_length());
  geometry.least_coordinate = -end;
  geometry.largest_coordinate = 1 + end;
  geometry.unit_coordinate = UnitMap::of(-end, 1 + end);

  // 2. The ends of the stripes.
  const StripeEnds ends = stripe_ends(plane, geometry.unit_coordinate, margin);
  if (!ends.are_usable()) return std::nullopt;

  const UnitMap unit_place = UnitMap::of(ends.low.minCoeff(), ends.high.maxCoeff());
  set_place(geometry, plane, unit_place);

  const auto low_edge = fitted_edge(unit_place.scale * ends.low.array() + unit_place.offset);
  const auto high_edge = fitted_edge(unit_place.scale * ends.high.array() + unit_place.offset);

  // 3. The lens: polynomials if they are exact enough, otherwise a start for Newton's method.
  auto lens = fitted(added_by_lens(plane, ends, unit_place, false), lens_tolerance,
                     PlanePolynomial::largest_degree);
  if (low_edge && high_edge && lens) {
    geometry.low_edge = *low_edge;
    geometry.high_edge = *high_edge;
  } else {
    // Outside the field, where the model may turn back, any start will do.
    lens = fitted(added_by_lens(plane, ends, unit_place, true), start_tolerance,
                  SolvedLens::start_degree);
    geometry.solved = plane.solved(unit_place, end, margin);
    if (!lens || !geometry.solved) return std::nullopt;
  }

  geometry.lens = *lens;
  return geometry;
}

}  // namespace slipstream
