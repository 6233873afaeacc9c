#pragma once

#include "slipstream/cloud.h"
#include "slipstream/maps.h"

namespace slipstream {

/// Steps between surfaces, as edge_sigma() judges them.
struct EdgeModel {
  /// A step, in distances between pixels: 79 degrees and more may be an edge.
  static constexpr double steep = 5;
  /// Least step, standard deviations of depth: as where clouds are cleaned.
  static constexpr double deviations = 5.5;
  /// Standard deviation of a point that may lie anywhere on a step, shares of it: 1 / sqrt(12).
  static constexpr double off_centre = 0.29;
  /// Share of the other surface that a lens mixes in.
  static constexpr double by_lens = 0.1;
};

/// Uncertainty of a coordinate beside an edge of surface, light or reflectivity, fields.
/// Elsewhere it is only the pull of contrast, nearly 0. `depth_by_y`: change of the depth with the
/// coordinate, mm per field; `noise`: standard deviation of the coordinate.
double edge_sigma(const Cloud& cloud, const Maps& maps, int column, int row, double depth_by_y,
                  double noise);

}  // namespace slipstream
