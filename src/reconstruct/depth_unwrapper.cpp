#include "reconstruct/depth_unwrapper.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>

#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"
#include "codes/predicted_variance.h"
#include "decode/band_unwrapper.h"
#include "geometry/stripe_geometry.h"
#include "reconstruct/engine_setup.h"
#include "reconstruct/points.h"
#include "slipstream/unwrapping.h"

namespace slipstream {
namespace {

/// Depth up to which a range from `nearest` spans this share of the field.
double farthest_within(const EngineSetup& setup, const Eigen::Vector3d& ray, double share) {
  // Bisection: 50 halvings reach the rounding of a double.
  double near = *setup.settings.nearest, far = *setup.settings.farthest;
  const double start = coordinate_of(near * ray, setup);
  for (int i = 0; i < 50; ++i) {
    const double middle = (near + far) / 2;
    (std::abs(coordinate_of(middle * ray, setup) - start) < share ? near : far) = middle;
  }

  return near;
}

void require_narrow(const EngineSetup& setup, double periods) {
  const double nearest = *setup.settings.nearest, farthest = *setup.settings.farthest;
  const Size size = setup.scanner.camera.size;

  // The middle pixel stands for all.
  const Eigen::Vector3d ray =
      ray_through(setup.scanner.camera, {(size.width - 1) / 2.0, (size.height - 1) / 2.0});
  const double covered =
      std::abs(coordinate_of(farthest * ray, setup) - coordinate_of(nearest * ray, setup));

  throw_if(!std::isfinite(covered),
           "nearest depth {} mm is behind the projector; choose a larger one", nearest);
  if (covered * periods < 1 || setup.sequence.strategy.is_spectral()) return;

  // The message proposes a range and a number of periods that would do.
  constexpr double sure = 0.95;  // of a period: the rest is for noise
  throw Error(fmt::format(
      "depths from {} to {} mm span {:.2f} of {} periods at the middle of the image; the "
      "fringe order needs less than one: use {} to {:.5g} mm, or {:.3g} periods",
      nearest, farthest, covered * periods, periods, nearest,
      farthest_within(setup, ray, sure / periods), sure / covered));
}

}  // namespace

DepthUnwrapper::DepthUnwrapper(const EngineSetup& setup)
    : periods_(highest_frequency(setup.sequence.strategy)),
      noise_(static_cast<float>(
          periods_ * std::sqrt(coordinate_variance(setup.sequence.strategy.layout(), 1,
                                                   cue_settings(setup).noise_variance)))),
      by_surfaces_(setup.sequence.strategy.is_spectral()),
      least_modulation_(static_cast<float>(setup.settings.minimum_modulation)),
      bounds_(setup.scanner.camera.size) {
  require_narrow(setup, periods_);

  // Bounds of each pixel's coordinate, up to a little past the field: the ends of the depth range.
  const double end = farthest_past_field(projector_length(setup));
  for_each_pixel(bounds_.size(), [&](int column, int row) {
    const Eigen::Vector3d ray = ray_through(setup.scanner.camera, {column, row});

    const double near = coordinate_of(*setup.settings.nearest * ray, setup);
    const double far = coordinate_of(*setup.settings.farthest * ray, setup);
    const bool known = std::isfinite(near) && std::isfinite(far);

    const double least = std::max(std::min(near, far), -end),
                 largest = std::min(std::max(near, far), 1 + end);
    bounds_(column, row) = {static_cast<float>(known ? least * periods_ : nan),
                            static_cast<float>(known ? largest * periods_ : nan)};
  });
}

void DepthUnwrapper::operator()(const Image<float>& wrapped_phase, const Image<float>& modulation,
                                double full_scale, DepthOrders& to) const {
  const Size size = bounds_.size();
  if (to.order.size() != size) {
    to.order = Image<int>(size);
    to.validity = Image<Validity>(size);
    to.possible = Image<OrderRange>(size);
    to.phase = Image<float>(size);
  }

  // 1. The orders that each pixel's depth range leaves.
  const auto grey_level = static_cast<float>(full_scale / 255);
  for_each_pixel(size, [&](int column, int row) {
    const float phi = wrapped_phase(column, row), levels = modulation(column, row) / grey_level;
    const bool lit = !by_surfaces_ || levels >= least_modulation_;
    to.phase(column, row) = lit ? phi : std::numeric_limits<float>::quiet_NaN();
    to.possible(column, row) = possible(phi, levels, bounds_(column, row));
  });

  // 2. Spectral strategies: one order for each connected surface.
  const Image<int>* const orders =
      by_surfaces_ ? &to.by_surfaces(to.phase, by_possible_orders(to.possible)) : nullptr;

  // 3. The order, if it is the only candidate or its surface's, and otherwise why there is none.
  for_each_pixel(size, [&](int column, int row) {
    const auto [first, last] = to.possible(column, row);
    const bool known = !std::isnan(bounds_(column, row).least);

    int order = first == last ? first : SurfaceOrders::none;
    if (orders != nullptr) order = (*orders)(column, row);
    to.order(column, row) = order;

    Validity& validity = to.validity(column, row);
    validity = known && first > last ? Validity::out_of_range : Validity::doubtful_order;
    if (order != SurfaceOrders::none) validity = Validity::valid;
  });
}

template <class Real>
void DepthUnwrapper::unwrap(const Image<Real>& wrapped_phase, const Image<int>& order,
                            Image<Real>& coordinate) const {
  if (coordinate.size() != order.size()) coordinate = Image<Real>(order.size());
  for_each_pixel(order.size(), [&](int column, int row) {
    const int k = order(column, row);
    const double y = unwrapped_coordinate(wrapped_phase(column, row), k, periods_);
    coordinate(column, row) = static_cast<Real>(k == SurfaceOrders::none ? nan : y);
  });
}

template void DepthUnwrapper::unwrap(const Image<float>&, const Image<int>&, Image<float>&) const;

Image<Validity> DepthUnwrapper::operator()(BasicMaps<double>& maps, double full_scale) const {
  DepthOrders orders;
  (*this)(converted<float>(maps.wrapped_phase), converted<float>(maps.modulation), full_scale,
          orders);
  unwrap(maps.wrapped_phase, orders.order, maps.coordinate);
  return std::move(orders.validity);
}

/// Orders whose coordinate lies between the bounds, with a margin for noise.
OrderRange DepthUnwrapper::possible(float phi, float modulation, const Bounds& bounds) const {
  constexpr float sigmas = 4;
  if (std::isnan(bounds.least) || std::isnan(phi)) return {};

  // Phase noise is proportional to 1 / B. Coordinates are in periods: cycles + order.
  const float cycles = phi / (2 * std::numbers::pi_v<float>);
  const float margin = sigmas * noise_ / std::max(modulation, 1e-3F);

  // Clamped, because in the dark the margin is huge and an int cannot hold it.
  const auto floor = [](float value) {
    const int towards_0 = static_cast<int>(std::clamp(value, -1e4F, 1e4F));
    return towards_0 - (static_cast<float>(towards_0) > value ? 1 : 0);
  };

  // From the ceiling of the lower bound, -floor(-x), to the floor of the upper one.
  return {static_cast<std::int16_t>(-floor(cycles + margin - bounds.least)),
          static_cast<std::int16_t>(floor(bounds.largest + margin - cycles))};
}

}  // namespace slipstream
