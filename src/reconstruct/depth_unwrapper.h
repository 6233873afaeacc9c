#pragma once

#include "decode/surface_orders.h"
#include "slipstream/engine.h"

namespace slipstream {

/// Fringe orders of all pixels, with the buffers used to find them.
struct DepthOrders {
  Image<int> order{};  ///< SurfaceOrders::none for a pixel without an order
  /// `out_of_range` if no order lies in the depth range, `doubtful_order` if it is ambiguous.
  Image<Validity> validity{};
  Image<OrderRange> possible{};
  Image<float> phase{};
  SurfaceOrders by_surfaces{};
};

/// Finds fringe orders from the depth range (An, Hyun, Zhang 2016). Along a pixel's ray, the
/// nearest and farthest depth bound the projector coordinate; every order whose coordinate lies
/// between them is a candidate. All lit surfaces must lie in the range. Spectral strategies get one
/// order per connected surface, see by_possible_orders; others need a single candidate.
class DepthUnwrapper {
 public:
  /// Throws Error if, at the middle pixel, the range begins behind the projector or, for strategies
  /// that are not spectral, spans a period or more: few pixels would then have a single candidate.
  explicit DepthUnwrapper(const EngineSetup& setup);

  /// `full_scale`: largest grey level of the frames; `modulation` is in the same grey levels.
  void operator()(const Image<float>& wrapped_phase, const Image<float>& modulation,
                  double full_scale, DepthOrders& to) const;

  /// Coordinates from wrapped phases and orders; NaN where the order is SurfaceOrders::none.
  template <class Real>
  void unwrap(const Image<Real>& wrapped_phase, const Image<int>& order,
              Image<Real>& coordinate) const;

  /// Sets the coordinates of `maps`; returns why a pixel has none, see DepthOrders::validity.
  [[nodiscard]] Image<Validity> operator()(BasicMaps<double>& maps, double full_scale) const;

 private:
  /// Range of y along a pixel's ray, periods; NaN if unknown.
  struct Bounds {
    float least = 0;
    float largest = 0;
  };

  [[nodiscard]] OrderRange possible(float phi, float modulation, const Bounds& bounds) const;

  double periods_;
  float noise_;  ///< standard deviation, periods, where B is one grey level of 8 bits
  bool by_surfaces_;
  float least_modulation_;  ///< grey levels of 8 bits
  Image<Bounds> bounds_;
};

}  // namespace slipstream
