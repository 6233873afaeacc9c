#include "slipstream/calibrate/pose_captures.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/calibrate/geometry_calibration.h"
#include "slipstream/io/saved_scan.h"

namespace slipstream {
namespace {

void require_same(Size& known, Size size, const std::string& pose, const char* what) {
  if (known == Size{}) known = size;
  if (size == known) return;
  throw Error(
      fmt::format("{}: {} {}, but in the poses before {}; likely frames of two cameras are mixed: "
                  "all poses must be of one camera and projector",
                  pose, what, text_of(size), text_of(known)));
}

Scan read(const ScanFiles& files, const std::string& pose, PoseCaptures& captures) {
  Scan scan = load_frames(files);
  captures.warnings.insert(captures.warnings.end(), scan.warnings.begin(), scan.warnings.end());
  if (scan.sequence.projector == Size{}) {
    throw Error(fmt::format("{}: no projector size; give it with --projector", pose));
  }
  require_same(captures.camera, scan.frames.size(), pose, "frames of");
  require_same(captures.projector, scan.sequence.projector, pose, "patterns for");
  return scan;
}

/// Finds the board in one more pose and adds what it gave; returns that in words.
std::string add_pose(PoseCaptures& captures, const BoardScans& scans, const CalibrationBoard& board,
                     const BoardCaptureSettings& settings) {
  Scan x = read(scans.x, scans.name, captures), y = read(scans.y, scans.name, captures);
  try {
    BoardCapture found = board_capture(scans.name, board, std::move(x), std::move(y), settings);
    captures.findings.insert(captures.findings.end(), found.findings.begin(), found.findings.end());
    if (found.view) {
      captures.views.push_back(std::move(*found.view));
      return found.told;
    }
    captures.unused.push_back({scans.name, found.told});
    return fmt::format("left out: {}", found.told);
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", scans.name, error.what()));
  }
}

}  // namespace

void require_enough_poses(const PoseCaptures& captures, const std::string& folder) {
  if (captures.views.size() >= fewest_poses) return;
  const std::string first_reason =
      captures.unused.empty()
          ? ""
          : fmt::format(" ({}: {})", captures.unused[0].name, captures.unused[0].why);
  throw Error(fmt::format("{}: {} of {} poses can be used{}; at least {} are needed", folder,
                          captures.views.size(), captures.views.size() + captures.unused.size(),
                          first_reason, fewest_poses));
}

PoseCaptures capture_poses(const std::string& folder, const std::vector<BoardScans>& poses,
                           const std::vector<std::string>& excluded, const CalibrationBoard& board,
                           const BoardCaptureSettings& settings,
                           const std::function<void(const std::string& words)>& told) {
  for (const std::string& name : excluded) {
    const bool known = std::any_of(poses.begin(), poses.end(),
                                   [&](const BoardScans& pose) { return pose.name == name; });
    if (!known) {
      throw Error(fmt::format("--exclude {}: there is no such pose in {}", name, folder));
    }
  }
  PoseCaptures captures;
  for (const BoardScans& pose : poses) {
    if (std::find(excluded.begin(), excluded.end(), pose.name) == excluded.end()) {
      told(fmt::format("{}: {}", pose.name, add_pose(captures, pose, board, settings)));
    } else {
      captures.unused.push_back({pose.name, "excluded"});
      told("");
    }
  }
  return captures;
}

}  // namespace slipstream
