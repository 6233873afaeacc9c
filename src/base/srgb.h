#pragma once

#include <cmath>
#include <cstdint>

namespace slipstream {

/// Light of an sRGB level, both from 0 to 1: IEC 61966-2-1.
inline double linear_of_srgb(double level) {
  return level <= 0.04045 ? level / 12.92 : std::pow((level + 0.055) / 1.055, 2.4);
}

/// The reverse.
inline double srgb_of_linear(double light) {
  return light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1 / 2.4) - 0.055;
}

/// Light of an sRGB byte in 16 bits.
inline std::uint16_t linear_16_bits(std::uint8_t level) {
  return static_cast<std::uint16_t>(std::lround(65535 * linear_of_srgb(level / 255.0)));
}

}  // namespace slipstream
