#pragma once

#include "slipstream/geometry/scanner.h"
#include "slipstream/simulate/virtual_world.h"

namespace slipstream {

/// A second camera like the scanner's, beyond its projector and turned to the same place, with the
/// same projector: the scanner that the two make.
Scanner second_scanner(const Scanner& first);

/// A scene in the first camera's frame as it stands in the second's. Both scanners have one
/// projector.
Scene seen_from_second(const Scene& scene, const Scanner& first, const Scanner& second);

/// The world as a second camera of the same light sees it, with noise of its own.
VirtualWorld seen_from_second(const VirtualWorld& first);

}  // namespace slipstream
