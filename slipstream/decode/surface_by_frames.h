#pragma once

#include "slipstream/codes/layout.h"
#include "slipstream/decode/surface_orders.h"
#include "slipstream/decode/unwrap.h"

namespace slipstream {

/// With Unwrapping::surfaces: the order of a surface under which its single frames fit best. Each
/// shows 1 + cos(2 pi periods y + origin), as bright as the band is strong, times one number for
/// all of the surface, which need not be that of the other frames: a lens takes more away of one
/// carrier than of another. None where more than 4 % of the frames' squares are left, where another
/// order leaves less than a fifth more, and of surfaces of less than 2000 pixels or four periods.
/// Of two bands instead: that under which their phases agree, twice as well as under any other.
/// `layout` and `phases` must outlive it.
SurfaceChoice order_by_frames(const Layout& layout, const LayoutPhases& phases);

}  // namespace slipstream
