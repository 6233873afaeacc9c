#pragma once

#include <array>
#include <cstdint>

namespace slipstream {

/// A pixel of a picture for the screen.
struct Colour {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;

  friend bool operator==(const Colour&, const Colour&) = default;
};

using ColourMap = std::array<Colour, 256>;

/// The colours of depth, in the viewer as in pictures that are written: red over yellow and green
/// to violet, so that what is near stands out. Of even steps in hue, with yellow and cyan no
/// brighter than they must be.
ColourMap depth_colours();

/// Once round the hues, so that 2 pi looks as 0 does.
ColourMap phase_colours();

/// What the red, green and blue channel of a camera see of a projector's red, green and blue:
/// channel c of a white surface is the sum of mixture[c][p] times what it would be if the
/// projector's colour p were seen by a channel of its own, and mixture[c][3], its level without any
/// light of the projector, grey levels of 255.
using ColourMixture = std::array<std::array<double, 4>, 3>;

}  // namespace slipstream
