#pragma once

#include <vector>

#include <Eigen/Core>

namespace slipstream {

/// How a board differs from a flat print of the right proportions.
struct PrintShape {
  double bend = 0;            ///< height of its arch or twist, mm: quadratic in the board's places
  double bend_deviation = 0;  ///< standard deviation of that, mm, by how rough the places are
  double size = 0;            ///< diagonal, mm
  double stretch = 0;         ///< how much longer, for its length, it is down than across, - 1
  double stretch_deviation = 0;
};

/// By the corners as a calibration estimated them, mm, in the frame of the `printed` ones.
PrintShape print_shape(const std::vector<Eigen::Vector3d>& places,
                       const std::vector<Eigen::Vector3d>& printed);

}  // namespace slipstream
