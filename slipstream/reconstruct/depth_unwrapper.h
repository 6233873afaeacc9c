#pragma once

#include "slipstream/base/image.h"
#include "slipstream/cloud/cloud.h"
#include "slipstream/decode/maps.h"
#include "slipstream/decode/surface_orders.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream {

/// The order of every pixel, and the memory that finding it takes.
struct DepthOrders {
  Image<int> order{};  ///< SurfaceOrders::none where not valid
  /// `out_of_range` where there is no candidate, `doubtful_order` where there are several.
  Image<Validity> validity{};
  Image<OrderRange> possible{};
  Image<float> phase{};
  SurfaceOrders by_surfaces{};
};

/// The fringe order from the range of depth asked for (An, Hyun, Zhang 2016): along a pixel's ray
/// the nearest and the farthest depth bound the projector coordinate, and an order whose coordinate
/// lies between them is a candidate. All that is lit must lie in the range. Of frames that are
/// taken apart by their spectra each connected surface has one order, see by_possible_orders; of
/// others each pixel has that which is the only candidate.
class DepthUnwrapper {
 public:
  /// Throws Error where the range lies behind the projector at the middle pixel or, of what is no
  /// spectrum, covers a period or more there, so that little would have one candidate alone.
  explicit DepthUnwrapper(const EngineSetup& setup);

  /// `full_scale`: the largest grey level of the frames, whose levels the modulation has.
  void operator()(const Image<float>& wrapped_phase, const Image<float>& modulation,
                  double full_scale, DepthOrders& to) const;

  /// Coordinates of wrapped phases of those orders; NaN where there is none.
  template <class Real>
  void unwrap(const Image<Real>& wrapped_phase, const Image<int>& order,
              Image<Real>& coordinate) const;

  /// Gives the maps their coordinate, and says why where there is none: DepthOrders::validity.
  [[nodiscard]] Image<Validity> operator()(BasicMaps<double>& maps, double full_scale) const;

 private:
  /// Between which y lies, in periods, least first; NaN where that is not known.
  struct Bounds {
    float least = 0;
    float largest = 0;
  };

  [[nodiscard]] OrderRange possible(float phi, float modulation, const Bounds& bounds) const;

  double periods_;
  float noise_;  ///< standard deviation in periods where B is one grey level of 8 bits
  bool by_surfaces_;
  float least_modulation_;  ///< grey levels of 8 bits
  Image<Bounds> bounds_;
};

}  // namespace slipstream
