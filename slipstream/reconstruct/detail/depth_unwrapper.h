#pragma once

#include "slipstream/cloud/cloud.h"
#include "slipstream/cloud/maps.h"
#include "slipstream/image/image.h"
#include "slipstream/reconstruct/reconstruct_settings.h"

namespace slipstream {

/// The fringe order from the range of depth asked for (An, Hyun, Zhang 2016): along a pixel's ray
/// the nearest and the farthest depth bound the projector coordinate, and an order whose coordinate
/// lies between them is a candidate. All that is lit must lie in the range.
class DepthUnwrapper {
 public:
  /// Throws Error where the range covers a period or more at the middle pixel, so that little would
  /// have one candidate alone, or lies behind the projector there.
  explicit DepthUnwrapper(const EngineSetup& setup);

  struct Result {
    Image<double> coordinate{};  ///< y, see BasicMaps; NaN where not valid
    /// `out_of_range` where there is no candidate, `doubtful_order` where there are several.
    Image<Validity> validity{};
  };
  /// `full_scale`: the largest grey level of the frames.
  [[nodiscard]] Result operator()(const BasicMaps<double>& maps, double full_scale) const;

 private:
  /// Between which y lies, least first; NaN where that is not known.
  struct Bounds {
    double least = 0;
    double largest = 0;
  };

  double periods_;
  double noise_;  ///< standard deviation of y where B is one grey level of 8 bits
  Image<Bounds> bounds_;
};

}  // namespace slipstream
