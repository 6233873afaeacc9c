#pragma once

#include <cmath>
#include <cstdint>
#include <numbers>

namespace slipstream {

// Random numbers that are functions of their arguments alone, so that frames do not depend on the
// order in which threads render them.

/// A well-mixed 64-bit number for each counter (the finaliser of SplitMix64).
constexpr std::uint64_t mixed(std::uint64_t counter) {
  counter += 0x9e3779b97f4a7c15U;
  counter = (counter ^ (counter >> 30)) * 0xbf58476d1ce4e5b9U;
  counter = (counter ^ (counter >> 27)) * 0x94d049bb133111ebU;
  return counter ^ (counter >> 31);
}

/// In (0, 1).
constexpr double uniform(std::uint64_t key) {
  return (static_cast<double>(mixed(key) >> 11) + 0.5) * 0x1p-53;
}

/// Standard normal (Box and Muller).
inline double gaussian(std::uint64_t seed, std::uint64_t frame, std::uint64_t pixel) {
  const std::uint64_t key = mixed(seed) ^ mixed(frame << 40 ^ pixel);
  return std::sqrt(-2 * std::log(uniform(key))) *
         std::cos(2 * std::numbers::pi * uniform(mixed(key)));
}

}  // namespace slipstream
