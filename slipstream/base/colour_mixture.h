#pragma once

#include <array>

namespace slipstream {

/// What the red, green and blue channel of a camera see of a projector's red, green and blue:
/// channel c of a white surface is the sum of mixture[c][p] times what it would be if the
/// projector's colour p were seen by a channel of its own, and mixture[c][3], its level without any
/// light of the projector, grey levels of 255.
using ColourMixture = std::array<std::array<double, 4>, 3>;

}  // namespace slipstream
