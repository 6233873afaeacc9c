#pragma once

#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream {

/// The mean of the frames that the virtual scanner takes in `repetitions` of one scan, each with
/// noise and rounding of its own (seeds from the photometry's on): unquantised, in grey levels of 8
/// bits. `scan`: of the scene, taken once with patterns along the same axis. `repetitions` >= 1.
FrameSet take_averaged(const VirtualScan& scan, const PatternSet& patterns, Photometry photometry,
                       int repetitions);

}  // namespace slipstream
