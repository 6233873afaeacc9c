#include "slipstream/image.h"

#include <cmath>
#include <span>

#include "base/numbers.h"

namespace slipstream {
namespace {

/// Linear interpolation between equally spaced colours.
ColourMap between(std::span<const Colour> stops) {
  ColourMap map;

  for (std::size_t i = 0; i < map.size(); ++i) {
    // Between which stops the entry lies, and its share of the second.
    const double place =
        static_cast<double>(i * (stops.size() - 1)) / static_cast<double>(map.size() - 1);
    const auto before = std::min(static_cast<std::size_t>(place), stops.size() - 2);
    const double share = place - static_cast<double>(before);

    const auto mixed = [&](std::uint8_t Colour::*part) {
      return static_cast<std::uint8_t>(
          std::lround((1 - share) * stops[before].*part + share * stops[before + 1].*part));
    };

    map[i] = {mixed(&Colour::red), mixed(&Colour::green), mixed(&Colour::blue)};
  }

  return map;
}

}  // namespace

ColourMap depth_colours() {
  static constexpr std::array<Colour, 7> stops{{{222, 60, 50},
                                                {246, 140, 50},
                                                {240, 214, 80},
                                                {120, 205, 105},
                                                {50, 175, 190},
                                                {60, 110, 215},
                                                {122, 92, 200}}};
  return between(stops);
}

ColourMap phase_colours() {
  ColourMap map;

  for (std::size_t i = 0; i < map.size(); ++i) {
    // Cosines a third of a turn apart, between 10 % and 94 % of full brightness.
    const double turn = two_pi * static_cast<double>(i) / static_cast<double>(map.size());
    const auto part = [turn](int third) {
      const double level = 0.52 + 0.42 * std::cos(turn - two_pi * third / 3);
      return static_cast<std::uint8_t>(std::lround(255 * level));
    };

    map[i] = {part(0), part(1), part(2)};
  }

  return map;
}

}  // namespace slipstream
