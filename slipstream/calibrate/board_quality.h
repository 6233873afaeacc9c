#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "slipstream/calibrate/board_view.h"
#include "slipstream/geometry/scanner.h"

namespace slipstream {

/// The point nearest to the rays through a camera and a projector pixel, camera frame, mm.
Eigen::Vector3d point_between(const Scanner& scanner, const Eigen::Vector2d& camera,
                              const Eigen::Vector2d& projector);

/// A board measured with a scanner, corner by corner, against what a board is.
struct BoardQuality {
  double flatness = 0;        ///< RMS distance of the corners from their best plane, mm
  double scale_error = 0;     ///< mean over all pairs of corners of distance / printed distance - 1
  double distance_error = 0;  ///< RMS over all pairs of distance - printed distance, mm
};

/// Nothing where less than four corners are lit.
std::optional<BoardQuality> board_quality(const BoardView& view, const Scanner& scanner,
                                          const std::vector<Eigen::Vector3d>& printed);

}  // namespace slipstream
