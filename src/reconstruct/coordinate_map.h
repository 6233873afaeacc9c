#pragma once

#include "slipstream/engine.h"

namespace slipstream {

/// Points of projector coordinates, 0 to 1, cleaned; NaN gives `too_dark`, as does a modulation
/// below the minimum, both in grey levels of 255; without one all pixels are lit. The intensity is
/// 255. Throws Error as require_valid does, and for a map of another size than the camera's.
Cloud cloud_of_coordinates(Image<double> coordinates, const EngineSetup& setup,
                           const Image<float>& modulation = {});

}  // namespace slipstream
