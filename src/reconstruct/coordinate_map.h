#pragma once

#include <string>

#include "slipstream/engine.h"

namespace slipstream {

inline constexpr const char* map_forms =
    "coordinate (0 to 1 across the projector), pixels (of the projector) or phase:PERIODS "
    "(unwrapped, rad, 2 pi PERIODS across the projector)";

/// Projector coordinates, 0 to 1, of a map in one of the forms; NaN where invalid. `length`:
/// projector pixels along the axis. Throws Error for another form, and for values that it cannot
/// have: outside the projector, all in one of its pixels, or a wrapped phase of several periods.
Image<double> coordinates_of_map(Image<double> map, const std::string& form, int length);

/// Points of projector coordinates, 0 to 1, cleaned; NaN gives `too_dark`, as does a modulation
/// below the minimum, both in grey levels of 255; without one all pixels are lit. The intensity is
/// 255. Throws Error as require_valid does, and for a map of another size than the camera's.
Cloud cloud_of_coordinates(Image<double> coordinates, const EngineSetup& setup,
                           const Image<float>& modulation = {});

}  // namespace slipstream
