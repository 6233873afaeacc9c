#include "slipstream/reconstruct/detail/depth_unwrapper.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/geometry/stripe_geometry.h"
#include "slipstream/image/parallel_rows.h"
#include "slipstream/noise/predicted_variance.h"
#include "slipstream/unwrap/temporal_unwrapping.h"

namespace slipstream {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Where the projector lights the point of a ray at that depth; NaN where it is behind it.
double coordinate_at(const EngineSetup& setup, const Eigen::Vector3d& ray, double depth) {
  const Eigen::Vector3d point = in_projector_frame(setup.scanner, depth * ray);
  if (!(point.z() > 0)) return nan;
  const Lens& projector = setup.scanner.projector;
  return coordinate_along(setup.sequence.axis, project(projector, point), projector.size);
}

/// The depth up to which a range from `nearest` covers that share of a field.
double farthest_within(const EngineSetup& setup, const Eigen::Vector3d& ray, double share) {
  double near = *setup.settings.nearest, far = *setup.settings.farthest;
  const double start = coordinate_at(setup, ray, near);
  for (int i = 0; i < 50; ++i) {
    const double middle = (near + far) / 2;
    (std::abs(coordinate_at(setup, ray, middle) - start) < share ? near : far) = middle;
  }
  return near;
}

/// Throws Error unless each pixel has one order or, of a spectrum, whose edges are left out, each
/// surface may have.
void require_narrow(const EngineSetup& setup, double periods) {
  const double nearest = *setup.settings.nearest, farthest = *setup.settings.farthest;
  const Size size = setup.scanner.camera.size;
  const Eigen::Vector3d ray =
      ray_through(setup.scanner.camera, {(size.width - 1) / 2.0, (size.height - 1) / 2.0});
  const double covered =
      std::abs(coordinate_at(setup, ray, farthest) - coordinate_at(setup, ray, nearest));
  if (!std::isfinite(covered)) {
    throw Error(fmt::format("depths from {} mm on begin behind the projector; name a farther one",
                            nearest));
  }
  if (covered * periods < 1 || setup.sequence.strategy.is_spectral()) return;
  constexpr double sure = 0.95;  // of a period: noise takes the rest
  throw Error(
      fmt::format("depths from {} to {} mm cover {:.2f} of {} periods at the middle of the "
                  "picture, where less than one tells the fringe order; from {} to {:.5g} mm would "
                  "do, or {:.3g} periods",
                  nearest, farthest, covered * periods, periods, nearest,
                  farthest_within(setup, ray, sure / periods), sure / covered));
}

}  // namespace

DepthUnwrapper::DepthUnwrapper(const EngineSetup& setup)
    : periods_(highest_frequency(setup.sequence.strategy)),
      noise_(std::sqrt(coordinate_variance(setup.sequence.strategy.layout(), 1,
                                           cue_settings(setup).noise_variance))),
      by_surfaces_(setup.sequence.strategy.is_spectral()),
      least_modulation_(setup.settings.minimum_modulation),
      bounds_(setup.scanner.camera.size) {
  require_narrow(setup, periods_);
  const double end = farthest_past_field(projector_length(setup));
  for_each_row(bounds_.height(), [&](int row) {
    for (int column = 0; column < bounds_.width(); ++column) {
      const Eigen::Vector3d ray = ray_through(setup.scanner.camera, {column, row});
      const double near = coordinate_at(setup, ray, *setup.settings.nearest);
      const double far = coordinate_at(setup, ray, *setup.settings.farthest);
      const bool known = std::isfinite(near) && std::isfinite(far);
      bounds_(column, row) = known ? Bounds{std::max(std::min(near, far), -end),
                                            std::min(std::max(near, far), 1 + end)}
                                   : Bounds{nan, nan};
    }
  });
}

OrderRange DepthUnwrapper::possible(double phi, double modulation, const Bounds& bounds) const {
  constexpr double sigmas = 4;
  if (std::isnan(bounds.least)) return {};
  const double cycles = phi / (2 * std::numbers::pi);
  const double margin = sigmas * noise_ / std::max(modulation, 1e-3);
  return {static_cast<int>(std::ceil((bounds.least - margin) * periods_ - cycles)),
          static_cast<int>(std::floor((bounds.largest + margin) * periods_ - cycles))};
}

DepthUnwrapper::Result DepthUnwrapper::operator()(const BasicMaps<double>& maps,
                                                  double full_scale) const {
  const double grey_level = full_scale / 255;
  const Size size = bounds_.size();
  Image<OrderRange> orders(size);
  Image<double> phase = maps.wrapped_phase;
  for_each_row(size.height, [&](int row) {
    for (int column = 0; column < size.width; ++column) {
      const double B = maps.modulation(column, row) / grey_level;
      if (by_surfaces_ && B < least_modulation_) {
        phase(column, row) = nan;
      } else {
        orders(column, row) = possible(phase(column, row), B, bounds_(column, row));
      }
    }
  });
  Result result{Image<double>(size, nan), Image<Validity>(size, Validity::doubtful_order)};
  if (by_surfaces_) {
    result.coordinate = coordinate_by_surfaces(phase, periods_, by_possible_orders(orders));
  }
  for_each_row(size.height, [&](int row) {
    for (int column = 0; column < size.width; ++column) {
      const auto [first, last] = orders(column, row);
      const bool known = !std::isnan(bounds_(column, row).least);
      if (known && first > last) result.validity(column, row) = Validity::out_of_range;
      double& coordinate = result.coordinate(column, row);
      if (!by_surfaces_ && first == last) {
        coordinate = unwrapped_coordinate(phase(column, row), first, periods_);
      }
      if (!std::isnan(coordinate)) result.validity(column, row) = Validity::valid;
    }
  });
  return result;
}

}  // namespace slipstream
