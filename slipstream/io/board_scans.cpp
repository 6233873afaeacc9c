#include "slipstream/io/board_scans.h"

#include <algorithm>
#include <utility>

#include "slipstream/base/throw_if-inl.h"
#include "slipstream/io/recording.h"
#include "slipstream/io/saved_scan.h"
#include "slipstream/io/scan_pictures.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

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
    pattern_pictures(scan, frame_count(scan.sequence), "a scan with these steps");
  }
  return scan;
}

BoardScans scans_of(const fs::path& folder, ScanFiles x, ScanFiles y) {
  return {folder.filename().string(), [x = std::move(x), y = std::move(y)](Axis axis) {
            return load_frames(axis == Axis::x ? x : y);
          }};
}

BoardScans both_in_one(const fs::path& folder, const ScanChanges& changes, Axis first_axis) {
  ScanFiles both{.path = folder, .frames = images_in_folder(folder)};
  amend(both, changes);
  ScanFiles first = both;
  first.sequence = along(both.sequence, first_axis);
  const int each = frame_count(first.sequence);
  // An order of both scans, or the same one for each.
  std::vector<int>& of_each = std::ssize(both.order) == 2 * each ? first.order : both.order;
  of_each.clear();
  const std::vector<fs::path> pictures =
      pattern_pictures(both, 2 * each, "a scan along x and one along y");
  ScanFiles second = first;
  second.sequence = along(both.sequence, across(first_axis));
  first.frames.assign(pictures.begin(), pictures.begin() + each);
  second.frames.assign(pictures.begin() + each, pictures.end());
  if (first_axis == Axis::y) std::swap(first, second);
  return scans_of(folder, std::move(first), std::move(second));
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
    if (entry.is_directory() && is_scan_folder(entry.path())) folders.push_back(entry.path());
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
