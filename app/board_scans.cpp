#include "app/board_scans.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "slipstream/error/error.h"

namespace slipstream::app {
namespace fs = std::filesystem;
namespace {

void require_strategy(const ScanFlags& flags, const fs::path& folder) {
  if (flags.strategy) return;
  throw Error(fmt::format("{}: no scan.yaml in it; say what the pictures are with --strategy",
                          folder.string()));
}

/// What is not said by scan.yaml: the flags.
void apply(const ScanFlags& flags, Axis axis, ScanDescription& scan) {
  scan.strategy = strategy_from(flags, scan.strategy);
  scan.axis = axis;
  scan.light = light_from(flags, scan.light);
  scan.projector = projector_from(flags, scan.projector);
}

void require_count(const fs::path& folder, std::size_t count, int wanted, const char* what) {
  if (static_cast<int>(count) == wanted) return;
  throw Error(fmt::format("{}: {} frames, but {} takes {}", folder.string(), count, what, wanted));
}

ScanDescription one_axis(const fs::path& folder, const ScanFlags& flags, Axis axis) {
  ScanDescription scan;
  if (fs::exists(folder / "scan.yaml")) {
    scan = read_scan_description(folder / "scan.yaml");
    if (scan.axis != axis) {
      throw Error(fmt::format("{}: scan.yaml says axis {}, but the folder is for axis {}",
                              folder.string(), name_of(scan.axis), name_of(axis)));
    }
  } else {
    require_strategy(flags, folder);
    scan.frames = images_in_folder(folder);
  }
  apply(flags, axis, scan);
  require_count(folder, scan.frames.size(), frame_count(scan.strategy), "a scan with these steps");
  return scan;
}

BoardScans both_in_one(const fs::path& folder, const ScanFlags& flags, Axis first_axis) {
  require_strategy(flags, folder);
  const std::vector<fs::path> pictures = images_in_folder(folder);
  ScanDescription first, second;
  const Axis second_axis = first_axis == Axis::x ? Axis::y : Axis::x;
  apply(flags, first_axis, first);
  apply(flags, second_axis, second);
  const int each = frame_count(first.strategy);
  require_count(folder, pictures.size(), 2 * each, "a scan along x and one along y");
  first.frames.assign(pictures.begin(), pictures.begin() + each);
  second.frames.assign(pictures.begin() + each, pictures.end());
  const std::string name = folder.filename().string();
  if (first_axis == Axis::y) std::swap(first, second);
  return {name, std::move(first), std::move(second)};
}

/// What `calibrate geometry --report` leaves, which may be beside the poses.
bool is_report(const fs::path& folder) {
  return fs::exists(folder / "report.md");
}

BoardScans pose_in(const fs::path& folder, const ScanFlags& flags, Axis first_axis) {
  if (fs::is_directory(folder / "x") && fs::is_directory(folder / "y")) {
    return {folder.filename().string(), one_axis(folder / "x", flags, Axis::x),
            one_axis(folder / "y", flags, Axis::y)};
  }
  return both_in_one(folder, flags, first_axis);
}

}  // namespace

std::vector<BoardScans> board_scans(const fs::path& folder, const ScanFlags& flags,
                                    Axis first_axis) {
  if (!fs::is_directory(folder)) {
    throw Error(fmt::format("{}: no such folder; one folder for each pose of the board is wanted",
                            folder.string()));
  }
  std::vector<fs::path> folders;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory() && !is_report(entry.path())) folders.push_back(entry.path());
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
  for (const fs::path& pose : folders) poses.push_back(pose_in(pose, flags, first_axis));
  return poses;
}

}  // namespace slipstream::app
