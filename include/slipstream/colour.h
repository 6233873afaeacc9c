#pragma once

#include <array>
#include <cstdint>

namespace slipstream {

/// An 8-bit RGB pixel for the screen.
struct Colour {
  std::uint8_t red = 0, green = 0, blue = 0;

  friend bool operator==(const Colour&, const Colour&) = default;
};

using ColourMap = std::array<Colour, 256>;

/// Colour map for depth, in the viewer and in written pictures: red through yellow and green to
/// violet, so that near points stand out. Hue steps are even; yellow and cyan are no brighter than
/// necessary.
ColourMap depth_colours();

/// Cyclic hue map: 2 pi has the same colour as 0.
ColourMap phase_colours();

/// Crosstalk between the projector's red, green and blue and the camera's channels. Channel c of a
/// white surface is the sum over p of mixture[c][p] times the level that projector colour p alone
/// would give, plus mixture[c][3], the level without projector light, in grey levels of 255.
using ColourMixture = std::array<std::array<double, 4>, 3>;

}  // namespace slipstream
