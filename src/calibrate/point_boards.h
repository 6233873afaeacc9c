#pragma once

#include <optional>
#include <string>
#include <vector>

#include "geometry/pose_points.h"
#include "slipstream/board_capture.h"
#include "slipstream/calibration_board.h"
#include "slipstream/image.h"

namespace slipstream {

/// The conventions of the program that found the points.
struct PointConventions {
  /// Unit of the board's coordinates, mm; nullopt: metres for boards of less than two units, which
  /// no camera and projector see in mm; otherwise mm.
  std::optional<double> unit{};
  double first_pixel = 0;        ///< coordinate of the centre of the first pixel: 0, or 1 in MATLAB
  bool swaps_camera = false;     ///< its pixels are row, column
  bool swaps_projector = false;  ///< its pixels are row, column
};

/// Boards from points of another program, as calibrate_geometry takes them.
struct PointBoards {
  BoardViews views{};
  BoardPlaces places{};  ///< all points of the boards, mm, each pose's on Z = 0
  double spacing = 0;    ///< median distance of a point to the next, mm
  std::vector<UnusedPose> unused{};
  std::vector<std::string> notes{};  ///< conventions that were found, for the user
};

/// Points with the same board coordinates are the same place of one board, which may differ from
/// pose to pose. Rows and columns are exchanged where only that brings the pixels into the picture,
/// or where camera and projector mirror each other and only one device allows the exchange. Throws
/// Error for pixels outside the pictures, boards that are not flat, and conventions that the points
/// contradict but do not determine.
PointBoards boards_of_points(std::vector<PosePoints> poses, Size camera, Size projector,
                             const PointConventions& conventions);

}  // namespace slipstream
