#include "slipstream/io/board_scans.h"

#include <algorithm>
#include <utility>

#include "slipstream/base/throw_if-inl.h"
#include "slipstream/io/recording.h"
#include "slipstream/io/saved_scan.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

void require_count(const fs::path& folder, std::size_t count, int wanted, const char* what) {
  if (static_cast<int>(count) == wanted) return;
  throw Error(
      fmt::format("{}: {} frames, but {} has {}; likely a frame is missing, or --strategy, --steps "
                  "or --low-steps differ",
                  folder.string(), count, what, wanted));
}

/// The scan along `axis` in a pose's folder: x or x.slip, or an empty path.
fs::path scan_along(const fs::path& folder, Axis axis) {
  for (const char* ending : {"", ".slip"}) {
    const fs::path path = folder / (std::string(name_of(axis)) + ending);
    if (fs::is_directory(path) || is_recording(path)) return path;
  }
  return {};
}

ScanFiles one_axis(const fs::path& path, const ScanChanges& changes, Axis axis) {
  ScanFiles scan = scan_files_in(path, changes);
  throw_if(scan.described && axes_of(scan.sequence) != name_of(axis),
           "{}: has axis {}; expected {}", path.string(), axes_of(scan.sequence), name_of(axis));
  scan.sequence = along(scan.sequence, axis);
  if (fs::is_directory(path)) {
    require_count(path, scan.frames.size(), frame_count(scan.sequence), "a scan with these steps");
  }
  return scan;
}

BoardScans scans_of(const fs::path& folder, ScanFiles x, ScanFiles y) {
  return {folder.filename().string(), [x = std::move(x), y = std::move(y)](Axis axis) {
            return load_frames(axis == Axis::x ? x : y);
          }};
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
  return scans_of(folder, std::move(first), std::move(second));
}

/// Whether the folder is a report by `calibrate geometry --report`, which may be beside the poses.
bool is_report(const fs::path& folder) {
  return fs::exists(folder / "report.md");
}

bool has_both_axes(const fs::path& folder) {
  return !scan_along(folder, Axis::x).empty() && !scan_along(folder, Axis::y).empty();
}

BoardScans pose_in(const fs::path& folder, const ScanChanges& changes, Axis first_axis) {
  if (!has_both_axes(folder)) return both_in_one(folder, changes, first_axis);
  ScanFiles x = one_axis(scan_along(folder, Axis::x), changes, Axis::x);
  return scans_of(folder, std::move(x), one_axis(scan_along(folder, Axis::y), changes, Axis::y));
}

}  // namespace

std::vector<BoardScans> board_scans(const fs::path& folder, const ScanChanges& changes,
                                    Axis first_axis) {
  throw_if(!fs::is_directory(folder),
           "{}: no such folder; expected a folder with a subfolder for each pose", folder.string());
  if (has_both_axes(folder)) return {pose_in(folder, changes, first_axis)};
  std::vector<fs::path> folders;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    const bool pose = entry.is_directory() && !is_hidden(entry.path()) && !is_report(entry.path());
    if (pose) folders.push_back(entry.path());
  }
  std::sort(folders.begin(), folders.end(), [](const fs::path& a, const fs::path& b) {
    return before_in_order(a.filename().string(), b.filename().string());
  });
  throw_if(folders.empty(), "{}: no subfolders; expected one for each pose of the board",
           folder.string());
  std::vector<BoardScans> poses;
  poses.reserve(folders.size());
  for (const fs::path& pose : folders) poses.push_back(pose_in(pose, changes, first_axis));
  return poses;
}

}  // namespace slipstream
