#pragma once

#include <string_view>
#include <vector>

#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream {

/// "ideal", "bench", "harsh".
std::vector<std::string_view> world_names();

/// The effects that a world has or has not, by name: "shot-noise", "camera-blur" and so on.
std::vector<std::string_view> effect_names();

/// Light, optics and sensor by name, with changes after commas:
///   ideal   the equations alone, with constant noise;
///   bench   an honest lab: projector and camera of good make, in focus, a matt object;
///   harsh   all that goes wrong in a workshop, at once.
/// An effect's name puts it in as harsh has it, "no-" before it leaves it out: "ideal,shot-noise",
/// "harsh,no-gloss". Throws Error for a name that is none of these.
Photometry photometry_named(std::string_view text);

}  // namespace slipstream
