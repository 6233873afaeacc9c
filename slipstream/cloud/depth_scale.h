#pragma once

#include <cstdint>

namespace slipstream {

/// How 16 bits tell a depth: `offset` and `scale` times the number. 0 tells of no point.
struct DepthScale {
  float scale = 0.05F;  ///< mm, above 0; to 3.3 m
  float offset = 0;     ///< mm

  /// The number that is nearest to a depth; 0 where it is NaN, or where 16 bits cannot tell it.
  [[nodiscard]] std::uint16_t operator()(float z) const {
    const float number = (z - offset) * (1 / scale) + 0.5F;
    return static_cast<std::uint16_t>(
        static_cast<std::int32_t>(number >= 1 && number < 65536 ? number : 0));
  }
};

}  // namespace slipstream
