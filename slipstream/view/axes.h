#pragma once

#include <vector>

#include "slipstream/view/line_renderer.h"
#include "slipstream/view/orbit_camera.h"

namespace slipstream::view {

/// The scanner's axes along the edges of the box from its lower left front corner, X blue, Y green
/// and Z red as in Liu 2010, Fig. 2.3, with their letters, which face the eye.
std::vector<Line> axes(const Box& box, const OrbitCamera& camera);

/// Distance between the lines of the floor's grid: a round number of millimetres.
float grid_step(const Box& box);

/// The floor: lines along X and Z in the plane Y = `height` under the box and round it.
std::vector<Line> floor_grid(const Box& box, float height);

}  // namespace slipstream::view
