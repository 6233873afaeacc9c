#pragma once

#include "slipstream/engine.h"

namespace slipstream {

/// Points of projector coordinates, 0 to 1, cleaned; NaN gives `too_dark`, as does a modulation
/// below the minimum, both in grey levels of 255; without one all pixels are lit. The intensity is
/// 255. `corrected`: receives the coordinates and, if contrast is corrected, its pull; null: not
/// wanted. Throws Error as require_valid does, for a map of another size than the camera's, and if
/// contrast is corrected without a modulation. Only maps from phases have the pull of contrast,
/// which a map itself does not show.
Cloud cloud_of_coordinates(Image<double> coordinates, const EngineSetup& setup,
                           const Image<float>& modulation = {}, Maps* corrected = nullptr);

}  // namespace slipstream
