#pragma once

#include <cstdint>

#include "slipstream/cloud/cloud.h"
#include "slipstream/decode/maps.h"

namespace slipstream {

/// What is wanted of a scan, by any engine; null is not wanted. At most one of cloud, depth,
/// depth16 and points, and no maps beside points. Memory that an output has is used again where it
/// is of the picture's size.
struct Outputs {
  Cloud* cloud = nullptr;
  Depth* depth = nullptr;
  Image<std::uint16_t>* depth16 = nullptr;  ///< depth by `scale`, without reasons
  PackedPoints* points = nullptr;           ///< by the fused pass alone
  Maps* maps = nullptr;  ///< coordinates as each pixel says them, not confirmed by its neighbours
  Image<float>* modulation = nullptr;  ///< that of the maps, where the rest of them is not wanted
  DepthScale scale{};

  [[nodiscard]] bool makes_points() const {
    return cloud != nullptr || depth != nullptr || depth16 != nullptr || points != nullptr;
  }
};

}  // namespace slipstream
