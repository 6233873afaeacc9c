#pragma once

#include <span>
#include <string>
#include <vector>

#include <Eigen/Geometry>

#include "base/page.h"
#include "slipstream/board_capture.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// Differences between points as the camera and as the robot give them.
struct TouchTest {
  std::vector<Eigen::Vector3d> differences;  ///< camera less robot, mm, in the robot's base frame
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Vector3d standard_error = Eigen::Vector3d::Zero();  ///< of the mean; NaN for one point
  double rms = 0;                                            ///< of the distances, mm
  double largest = 0;                                        ///< distance, mm
};

/// `points`: as the camera measured them, mm. `camera`: camera to base, when they were measured.
/// `tools`: tool to base, with the tip on each point. `tip`: in the tool's frame, mm. Throws Error
/// unless there is a tool for each point, and at least one.
TouchTest touch_test(std::span<const Eigen::Vector3d> points, const Eigen::Isometry3d& camera,
                     std::span<const Eigen::Isometry3d> tools, const Eigen::Vector3d& tip);

/// The same for light instead of a tip: the outer corner of the board that is nearest to each
/// point, less the place where the projector's ray to that point meets the board. An error along
/// these rays does not show. `view`: a scan of the board along both axes. `points`: corners as the
/// robot has them, mm, in its base frame. Throws Error if such a corner is not lit, if two points
/// have the same one, and without points.
TouchTest projection_test(const BoardView& view, const CalibrationBoard& board,
                          const Scanner& scanner, const Eigen::Isometry3d& camera,
                          std::span<const Eigen::Vector3d> points);

/// "good", or "bad" with the offset and its direction if the mean is off by more than `tolerance`,
/// mm, beyond twice its standard error; "usable" if only single points are.
Verdict verdict_of(const TouchTest& test, double tolerance);

/// "+0.512 mm in x, -0.03 mm in y, +0.00 mm in z".
std::string signed_text_of(const Eigen::Vector3d& offset);

}  // namespace slipstream
