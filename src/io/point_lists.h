#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "geometry/pose_points.h"

// Points of calibration boards that other programs found.
namespace slipstream {

/// The contents of a file of points.
struct PointLists {
  std::vector<PosePoints> poses{};
  /// How the columns were read, for the user: one line.
  std::string layout{};
};

/// Reads points of a board in camera and projector: a table (.txt, .csv, .dat) with a row for each
/// point, or text and NumPy files (.npz, .npy) with an array for board, camera and projector, for
/// all poses or for each, in a folder or in one .npz file. Names of columns, arrays and files say
/// their meaning; without them a table has the columns pose, board x, y and perhaps z, camera u, v,
/// projector u, v. A point without a pixel has NaN, empty fields, -1 -1 or 0 0. Throws Error with
/// the file if names and sizes leave their meaning open.
PointLists read_point_lists(const std::filesystem::path& path);

/// Writes a table that read_point_lists reads.
void write_point_list(const std::filesystem::path& path, const std::vector<PosePoints>& poses);

}  // namespace slipstream
