#pragma once

#include "slipstream/simulate/mesh.h"

namespace slipstream {

/// A bust with a ring held before its chest: rounded, grooved and undercut, and in its own shadow
/// in places. About 1 high, centred on the origin, Y up, facing +Z.
Mesh statue();

}  // namespace slipstream
