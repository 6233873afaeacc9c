#pragma once

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

}  // namespace slipstream
