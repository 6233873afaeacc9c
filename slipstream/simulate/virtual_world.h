#pragma once

#include <string_view>
#include <vector>

#include "slipstream/geometry/scanner.h"
#include "slipstream/simulate/scene.h"
#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream {

/// A scanner, what stands before it, and how light and sensor are.
struct VirtualWorld {
  Scanner scanner{};
  Scene scene{};
  Photometry photometry{};
};

/// The world's scanner with what a calibration of light and sensor would find, rounding included,
/// and the depths that boards before it cover.
Scanner as_calibrated(const VirtualWorld& world);

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

/// A second camera like the scanner's, beyond its projector and turned to the same place, with the
/// same projector: the scanner that the two make.
Scanner second_scanner(const Scanner& first);

/// A scene in the first camera's frame as it stands in the second's. Both scanners have one
/// projector.
Scene seen_from_second(const Scene& scene, const Scanner& first, const Scanner& second);

/// The world as a second camera of the same light sees it, with noise of its own.
VirtualWorld seen_from_second(const VirtualWorld& first);

}  // namespace slipstream
