#pragma once

#include "slipstream/geometry/scan.h"

namespace slipstream {

/// What the virtual scanner sees of a statue before a wall, 8 bits, with noise and an ambient light
/// that it knows, stripes along x.
Scan bench_scan(const Strategy& strategy, Size camera = {640, 480});

/// Each pixel k x k pixels of a camera of k times the width and height: the same scene and geometry
/// without hours of rendering.
Scan enlarged(const Scan& scan, int k);

}  // namespace slipstream
