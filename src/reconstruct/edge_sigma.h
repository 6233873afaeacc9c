#pragma once

#include "slipstream/cloud.h"
#include "slipstream/maps.h"

namespace slipstream {

/// Uncertainty of a coordinate beside an edge of surface, light or reflectivity, fields.
/// Elsewhere it is only the pull of contrast, nearly 0. `depth_by_y`: change of the depth with the
/// coordinate, mm per field; `noise`: standard deviation of the coordinate.
double edge_sigma(const Cloud& cloud, const Maps& maps, int column, int row, double depth_by_y,
                  double noise);

}  // namespace slipstream
