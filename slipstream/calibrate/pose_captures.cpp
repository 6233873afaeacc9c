#include "slipstream/calibrate/pose_captures.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/calibrate/geometry_calibration.h"
#include "slipstream/io/recording.h"
#include "slipstream/io/saved_scan.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

void require_count(const fs::path& folder, std::size_t count, int wanted, const char* what) {
  if (static_cast<int>(count) == wanted) return;
  throw Error(
      fmt::format("{}: {} frames, but {} takes {}; likely a frame is missing, or --strategy, "
                  "--steps or --low-steps are others",
                  folder.string(), count, what, wanted));
}

/// The scan of that axis in a pose's folder: x or x.slip; empty where there is neither.
fs::path scan_along(const fs::path& folder, Axis axis) {
  for (const char* ending : {"", ".slip"}) {
    const fs::path path = folder / (std::string(name_of(axis)) + ending);
    if (fs::is_directory(path) || is_recording(path)) return path;
  }
  return {};
}

ScanFiles one_axis(const fs::path& path, const ScanChanges& changes, Axis axis) {
  ScanFiles scan = scan_files_in(path, changes);
  if (scan.described && axes_of(scan.sequence) != name_of(axis)) {
    throw Error(fmt::format("{}: says axis {}, but it is for axis {}", path.string(),
                            axes_of(scan.sequence), name_of(axis)));
  }
  scan.sequence = along(scan.sequence, axis);
  if (fs::is_directory(path)) {
    require_count(path, scan.frames.size(), frame_count(scan.sequence), "a scan with these steps");
  }
  return scan;
}

BoardScans both_in_one(const fs::path& folder, const ScanChanges& changes, Axis first_axis) {
  const std::vector<fs::path> pictures = images_in_folder(folder);
  ScanFiles first{.path = folder, .frames = pictures};
  amend(first, changes);
  first.sequence = along(first.sequence, first_axis);
  ScanFiles second = first;
  second.sequence = along(first.sequence, across(first_axis));
  const int each = frame_count(first.sequence);
  require_count(folder, pictures.size(), 2 * each, "a scan along x and one along y");
  first.frames.assign(pictures.begin(), pictures.begin() + each);
  second.frames.assign(pictures.begin() + each, pictures.end());
  if (first_axis == Axis::y) std::swap(first, second);
  return {folder.filename().string(), std::move(first), std::move(second)};
}

/// What `calibrate geometry --report` leaves, which may be beside the poses.
bool is_report(const fs::path& folder) {
  return fs::exists(folder / "report.md");
}

bool has_both_axes(const fs::path& folder) {
  return !scan_along(folder, Axis::x).empty() && !scan_along(folder, Axis::y).empty();
}

BoardScans pose_in(const fs::path& folder, const ScanChanges& changes, Axis first_axis) {
  if (!has_both_axes(folder)) return both_in_one(folder, changes, first_axis);
  return {folder.filename().string(), one_axis(scan_along(folder, Axis::x), changes, Axis::x),
          one_axis(scan_along(folder, Axis::y), changes, Axis::y)};
}

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

std::vector<BoardScans> board_scans(const fs::path& folder, const ScanChanges& changes,
                                    Axis first_axis) {
  if (!fs::is_directory(folder)) {
    throw Error(fmt::format("{}: no such folder; one folder for each pose of the board is wanted",
                            folder.string()));
  }
  if (has_both_axes(folder)) return {pose_in(folder, changes, first_axis)};
  std::vector<fs::path> folders;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const bool pose = entry.is_directory() && !is_hidden(entry.path()) && !is_report(entry.path());
    if (pose) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end(), [](const fs::path& a, const fs::path& b) {
    return before_in_order(a.filename().string(), b.filename().string());
  });
  if (folders.empty()) {
    throw Error(fmt::format("{}: no folder in it; one for each pose of the board is wanted",
                            folder.string()));
  }
  std::vector<BoardScans> poses;
  poses.reserve(folders.size());
  for (const fs::path& pose : folders) poses.push_back(pose_in(pose, changes, first_axis));
  return poses;
}

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
