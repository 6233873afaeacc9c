#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "slipstream/calibrate/board_capture.h"
#include "slipstream/io/scan_folder.h"

namespace slipstream {

/// The two scans of a board pose: what their pictures are and where.
struct BoardScans {
  std::string name;  ///< of the pose's folder
  ScanFiles x;
  ScanFiles y;
};

/// The poses in a folder, in the order of their names with numbers counted: each a folder that
/// holds
///   - scans x and y: folders, with scan.yaml or without, or recordings x.slip and y.slip; or
///   - the pictures of both scans, those along `first_axis` first in order of their names.
/// A folder with a report.md is none, and a folder that is itself a pose with x and y is the one.
/// Throws Error where there is none, one is neither, or as scan_files_in.
std::vector<BoardScans> board_scans(const std::filesystem::path& folder, const ScanChanges& changes,
                                    Axis first_axis);

/// A pose that took no part.
struct UnusedPose {
  std::string name;
  std::string why;
};

/// What all poses of a board together gave.
struct PoseCaptures {
  std::vector<BoardView> views{};
  std::vector<UnusedPose> unused{};
  Size camera{};
  Size projector{};
  std::vector<std::string> warnings{};  ///< of reading the frames
  std::vector<Finding> findings{};      ///< of the poses' frames
};

/// Finds the board in all poses but the `excluded`, by name. `told` is called after each with what
/// it gave in words, with nothing where it was excluded. Throws Error, naming the pose, where its
/// frames cannot be read, do not serve, or are of another camera or projector than those before,
/// and for an excluded name that no pose in the folder has.
PoseCaptures capture_poses(const std::string& folder, const std::vector<BoardScans>& poses,
                           const std::vector<std::string>& excluded, const CalibrationBoard& board,
                           const BoardCaptureSettings& settings,
                           const std::function<void(const std::string& words)>& told);

/// Throws Error, naming the folder, where fewer poses can be used than a calibration needs.
void require_enough_poses(const PoseCaptures& captures, const std::string& folder);

}  // namespace slipstream
