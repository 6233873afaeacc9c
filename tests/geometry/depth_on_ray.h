// The depth that StripeGeometry describes, in double.
#pragma once

#include "geometry/stripe_geometry.h"

namespace slipstream {

struct DepthOnRay {
  double z = 0;                   ///< mm; not finite or not positive without a point
  bool before_projector = false;  ///< false if behind it
  bool in_field = false;          ///< including the margin along the stripe
};

/// Of the point on the ray that the projector lights at the coordinate y, for lenses that are not
/// solved.
inline DepthOnRay depth_on_ray(const StripeGeometry& geometry, double E_x, double E_y, double y) {
  const Eigen::Vector3d e(E_x, E_y, 1);
  const double g = geometry.facing * e;
  const double p = geometry.unit_coordinate(y);
  const double q = (geometry.place_constant.dot(e) + p * geometry.place_slope.dot(e)) / g;
  const double w = y + geometry.lens(p, q);
  const double numerator = w * geometry.depth(3) - geometry.coordinate(3);
  const double denominator =
      geometry.coordinate.head<3>().dot(e) - w * geometry.depth.head<3>().dot(e);
  const auto [least, largest] = geometry.places_at(p);
  return {.z = numerator / denominator,
          .before_projector = denominator * g > 0,
          .in_field = y >= geometry.least_coordinate && y <= geometry.largest_coordinate &&
                      q >= least && q <= largest};
}

}  // namespace slipstream
