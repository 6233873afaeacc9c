#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <random>
#include <vector>

namespace slipstream {

using Bytes = std::vector<std::uint8_t>;

/// `seed` with a few bytes changed, doubled, left out or cut off, as damage and malice do.
inline Bytes mutated(Bytes seed, std::mt19937& random) {
  static constexpr std::array<std::uint8_t, 8> telling{0, 1, 0x7f, 0x80, 0xfe, 0xff, '-', '\n'};
  const auto below = [&](std::size_t end) { return random() % std::max<std::size_t>(1, end); };
  for (std::size_t changes = 1 + below(4); changes > 0; --changes) {
    const std::size_t at = below(seed.size()), length = 1 + below(8);
    const auto first = seed.begin() + static_cast<std::ptrdiff_t>(std::min(at, seed.size()));
    const auto end = seed.begin() + static_cast<std::ptrdiff_t>(std::min(at + length, seed.size()));
    switch (below(6)) {
      case 0:
        if (at < seed.size()) seed[at] = static_cast<std::uint8_t>(random());
        break;
      case 1:
        std::fill(first, end, telling[below(telling.size())]);
        break;
      case 2:
        if (at < seed.size()) seed[at] ^= static_cast<std::uint8_t>(1U << below(8));
        break;
      case 3: {
        const Bytes part(first, end);
        seed.insert(first, part.begin(), part.end());
        break;
      }
      case 4:
        seed.erase(first, end);
        break;
      default:
        if (below(4) == 0) seed.resize(at);
    }
  }
  return seed;
}

}  // namespace slipstream
