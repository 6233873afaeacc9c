#include "reconstruct/fused/point_stage.h"

#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "reconstruct/fused/narrow.h"

namespace slipstream {
namespace {

std::vector<float> kernel_order(const PlanePolynomial& polynomial, int degree) {
  std::vector<float> coefficients;

  // The kernel's degree may be higher than the polynomial's: its other terms are 0.
  auto c = polynomial.coefficients.begin();
  for (int i = 0; i <= degree; ++i) {
    for (int j = 0; i + j <= degree; ++j) {
      coefficients.push_back(i + j <= polynomial.degree ? narrow(*c++) : 0);
    }
  }

  std::reverse(coefficients.begin(), coefficients.end());
  return coefficients;
}

template <class Row>
RayTerms linear(const Row& row) {
  return {narrow(row(0)), narrow(row(1)), narrow(row(2))};
}

EdgeTerms edge(const std::array<double, StripeGeometry::edge_terms>& terms) {
  EdgeTerms all{};
  std::transform(terms.begin(), terms.end(), all.begin(), narrow);
  return all;
}

}  // namespace

PointStage point_stage(const StripeGeometry& geometry, const DepthRange& depths) {
  // The kernels exist for odd degrees from 3 on, for no lens (0) and for Newton's method (-1).
  const int needed = geometry.solved ? -1 : geometry.lens.degree;
  const int degree = needed < 1 ? needed : std::max(3, needed | 1);  // odd ones are compiled

  const auto [inner_low, inner_high] = geometry.inner_places();
  constexpr double largest = std::numeric_limits<float>::max();

  return {PointNumbers{.coordinate = linear(geometry.coordinate),
                       .depth = linear(geometry.depth),
                       .facing = linear(geometry.facing),
                       .place_constant = linear(geometry.place_constant),
                       .place_slope = linear(geometry.place_slope),
                       .coordinate_offset = narrow(geometry.coordinate(3)),
                       .depth_offset = narrow(geometry.depth(3)),
                       .unit_scale = narrow(geometry.unit_coordinate.scale),
                       .unit_offset = narrow(geometry.unit_coordinate.offset),
                       .least_coordinate = narrow(geometry.least_coordinate),
                       .largest_coordinate = narrow(geometry.largest_coordinate),
                       .lens_degree = degree,
                       .low_edge = edge(geometry.low_edge),
                       .high_edge = edge(geometry.high_edge),
                       .inner_low = narrow(inner_low),
                       .inner_high = narrow(inner_high),
                       .nearest = narrow(std::min(depths.nearest, largest)),
                       .farthest = narrow(std::min(depths.farthest, largest))},
          kernel_order(geometry.lens, geometry.solved ? SolvedLens::start_degree : degree),
          geometry.solved, depths.nearest > 0 || depths.farthest < largest};
}

}  // namespace slipstream
