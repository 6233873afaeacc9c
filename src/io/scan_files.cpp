#include "slipstream/scan_files.h"

#include <algorithm>
#include <bit>
#include <chrono>
#include <ctime>
#include <iterator>

#include <fmt/chrono.h>

#include "base/throw_if-inl.h"
#include "frames/colour_channels.h"
#include "io/file.h"
#include "io/file_names.h"
#include "io/image_file.h"
#include "io/matrix_files.h"
#include "io/scan_cameras.h"
#include "io/scan_colour.h"
#include "io/scan_folder.h"
#include "io/scan_pictures.h"
#include "io/scan_scanner.h"
#include "slipstream/recording.h"
#include "slipstream/scanner_file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

FrameSet recorded_frames(const ScanFiles& files) {
  const RecordingReader& recording = *files.recording;
  if (recording.header().in_colour) require_in_colour(files.sequence, files.path.string());

  const int bits = recording.header().format.bits;
  throw_if(bits != files.bits, "{}: its frames have {} bits; `camera_bits {}` is only for pictures",
           files.path.string(), bits, files.bits);

  naming(files.path.string(), [&] {
    require_scan_fits(static_cast<std::uint64_t>(cycle_length(files.sequence)),
                      byte_count(recording.header().format));
  });

  auto frames = window_at(recording, files.sequence, files.window);
  if (frames) return *std::move(frames);
  throw_if(files.window.has_value(),
           "{}: frames of window {} are missing or damaged; use another window",
           files.path.string(), files.window.value_or(0));
  throw Error(fmt::format("{}: {} frames, but no complete cycle of {} among the first",
                          files.path.string(), recording.count(), cycle_length(files.sequence)));
}

/// Writes one complete cycle.
void save_recording(const fs::path& path, const FrameViews& frames, RecordingHeader header) {
  const std::vector<Frame> cycle = frames_of(frames, path.string());
  header.format = cycle.front().format();
  header.sequence->marker = false;

  RecordingWriter writer(path, header, OutputFile::Writing::at_once);
  for (const Frame& frame : cycle) writer.append(frame);
  writer.finish();
}

/// Removes the frames of a longer scan that was here before.
void remove_other_frames(const fs::path& folder, const std::vector<fs::path>& names) {
  // Frames are numbered without gaps, so the first missing number ends the search.
  for (int n = 0;; ++n) {
    bool any = false;
    for (const char* ending : {"png", "tiff"}) {
      const fs::path name = folder / fmt::format("frame_{:02}.{}", n, ending);
      any |= std::ranges::find(names, name) != names.end() || fs::remove(name);
    }

    if (!any) return;
  }
}

FrameSet white_of(const ScanFiles& files) {
  if (files.recording) return files.recording->header().white;
  return files.white ? read_colour_frames({*files.white}) : FrameSet();
}

/// The frames as captured; grey pictures in pattern order. `colour` receives the mean of the frames
/// that show the colours, if they are in colour; null: not wanted.
Scan taken_scan(const ScanFiles& files, Image<ColourLevels>* colour) {
  Scan scan{.sequence = files.sequence};
  if (files.recording) {
    scan.frames = recorded_frames(files);
    scan.sequence.marker = false;  // the cycle contains no marker frame
    return scan;
  }

  if (is_in_colour(files)) {
    scan.frames = read_colour_frames(files.frames, files.bits);
    return scan;
  }

  // Grey pictures; the order may leave out some of the folder's.
  FrameReading reading{.bits = files.bits, .channel = files.channel, .mosaic = files.mosaic};
  if (colour != nullptr) reading.of_colour = frames_of_colour(files.sequence);
  LoadedFrames loaded = read_frames(pattern_pictures(files, frame_count(files.sequence)), reading);

  scan.frames = std::move(loaded.frames);
  if (colour != nullptr) *colour = std::move(loaded.colour);
  scan.warnings = std::move(loaded.warnings);

  // A code of black and white tolerates JPEG; the phase of sinusoids does not.
  if (loaded.lossy > 0 && !measuring_frames(scan.sequence.strategy.layout()).empty()) {
    scan.warnings.push_back(fmt::format(  // with the figures of docs/reference/files.md
        "{}: {} frames are JPEG, which costs accuracy: a virtual statue's median depth error is "
        "0.49 mm without, 0.40 at quality 90 (smoothed), 0.76 at 50 and 1.32 at 20; prefer PNG",
        files.path.string(), loaded.lossy));
  }

  return scan;
}

/// The frames in pattern order; separates colour channels with the mixture, if known. Colours of
/// the points are read if they are wanted.
Scan read_scan(const ScanFiles& files, const PhotometricCalibration& known, bool wants_colour) {
  const std::optional<ColourMixture>& mixture = known.colour_mixture;
  Image<ColourLevels> levels;
  Scan scan = taken_scan(files, wants_colour ? &levels : nullptr);
  FrameSet white;

  // Separates the projector's primaries, which the camera's channels mix.
  if (is_in_colour(files)) {
    white = white_of(files);
    if (mixture) scan.frames = unmixed(scan.frames, *mixture, white);

    const std::string doubt = doubt_about_colours(mixture.has_value(), white.count() != 0);
    if (!doubt.empty()) scan.warnings.push_back(doubt);
  }

  if (wants_colour) add_colour(scan, files, white, std::move(levels), known.white_balance);

  // taken_scan has already put grey pictures in order.
  scan.order = files.order;
  if (files.order.empty() || !(files.recording || is_in_colour(files))) return scan;

  const int count = scan.frames.count();
  throw_if(
      !is_order_of(files.order, count),
      "{}: `order {}` is not an order of its {} frames; list each of 0 to {} once, separated by "
      "commas",
      files.path.string(), text_of_order(files.order), count, count - 1);

  scan.frames = reordered(std::move(scan.frames), files.order);
  return scan;
}

/// Adds the guard. One along the scan's own axis, as after a change of the axis, shows nothing.
void add_guard(Scan& scan, const ScanFiles& files) {
  if (!files.guard || !scan.other_axis.empty()) return;

  // The guard shows the same camera and light.
  ScanChanges changes{.channel = files.channel};
  if (files.bits != 0) changes.bits = files.bits;
  Scan guard = load_frames(scan_files_in(*files.guard, changes));

  if (guard.sequence.axis == scan.sequence.axis || !guard.other_axis.empty()) {
    scan.warnings.push_back(
        fmt::format("{}: not used: its patterns must vary along {} alone, across the scan's",
                    files.guard->string(), name_of(across(scan.sequence.axis))));
    return;
  }
  throw_if(guard.frames.size() != scan.frames.size(),
           "{}: its pictures are not as large as the scan's; both must be the camera's whole ones",
           files.guard->string());
  scan.guard.push_back(std::move(guard));
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

  // Only checks the number of pictures; they are read later. A colour picture has three frames.
  if (fs::is_directory(path) && !is_in_colour(scan)) {
    pattern_pictures(scan, frame_count(scan.sequence));
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
  ScanFiles second = both;
  second.sequence = along(both.sequence, across(first_axis));
  const int in_first = frame_count(first.sequence);
  const int count = in_first + frame_count(second.sequence);

  // An order of both scans, or one for each: in words it depends on the code, which may be longer
  // along one axis.
  if (std::ssize(both.order) == count) {
    first.order.clear();
    second.order.clear();
  } else if (!both.order.empty()) {
    both.order.clear();
    first.order = order_from(changes.order, first.sequence);
    second.order = order_from(changes.order, second.sequence);
  }

  both.sequence = first.sequence;
  both.sequence.both_axes = true;
  const std::vector<fs::path> pictures = pattern_pictures(both, count);

  // The pictures of the scan along the first axis come first.
  first.frames.assign(pictures.begin(), pictures.begin() + in_first);
  second.frames.assign(pictures.begin() + in_first, pictures.end());

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

/// The scan in a folder, with or without a scan.yaml.
ScanFiles folder_files(const fs::path& path) {
  throw_if(!fs::is_directory(path), "{}: {}; expected a scan folder or a recording", path.string(),
           fs::exists(path) ? "is neither" : "no such folder or file");

  const fs::path description = path / "scan.yaml";
  if (fs::exists(description)) return read_scan_files(description);

  // Named first: GCC 12 destroys `path` twice if an initializer after it throws.
  std::vector<fs::path> frames = images_in_folder(path);
  return {.path = path, .frames = std::move(frames)};
}

/// A scanner's files: one or two, or those of a folder of matrices.
void add_scanner_files(const std::optional<fs::path>& scanner, std::vector<fs::path>& files) {
  if (!scanner) return;
  const auto parts = has_matrices(*scanner) ? matrix_files(*scanner) : scanner_files(*scanner);
  files.insert(files.end(), parts.begin(), parts.end());
}

}  // namespace

ListedFolder listed_folder(const fs::path& path) {
  ListedFolder folder{.description = folder_files(path)};
  folder.frames.swap(folder.description.frames);
  return folder;
}

ScanFiles scan_files_in(const fs::path& path, const ScanChanges& changes) {
  ScanFiles files;

  if (changes.recording || is_recording(path)) {
    files = recorded_files(path, changes.recording ? changes.recording
                                                   : std::make_shared<const RecordingReader>(path));
  } else if (changes.folder && changes.window) {
    files = changes.folder->description;  // the frames of the window follow
  } else {
    files = folder_files(path);
  }

  amend(files, changes);
  return files;
}

std::uint64_t window_count(const ScanFiles& files) {
  if (files.recording) return window_count(*files.recording, files.sequence);

  return window_count(files.frames.size(), files.sequence);
}

bool is_in_colour(const ScanFiles& files) {
  if (files.recording) return files.recording->header().in_colour;
  return 3 * static_cast<int>(files.frames.size()) == frame_count(files.sequence);
}

Scan load_frames(const ScanFiles& files) {
  PhotometricCalibration known;
  if (files.scanner && is_in_colour(files)) known = read_photometric_calibration(*files.scanner);

  return merged(read_scan(files, known, false));
}

Scan load_scan(const ScanFiles& files) {
  std::optional<Scanner> scanner = scanner_of(files);
  const PhotometricCalibration known = scanner ? scanner->photometry : PhotometricCalibration();
  Scan scan = merged(read_scan(files, known, true));

  add_scanner(scan, std::move(scanner), files);
  add_guard(scan, files);
  return scan;
}

Scan load_as_taken(const ScanFiles& files, FrameSet& white) {
  throw_if(!files.order.empty(),
           "{}: `order` is only for grey scans; the channels of a colour picture are captured "
           "together",
           files.path.string());

  Scan scan = taken_scan(files, nullptr);
  white = white_of(files);
  add_scanner(scan, scanner_of(files), files);
  add_colour(scan, files, white, {},
             scan.scanner ? scan.scanner->photometry.white_balance : std::nullopt);
  return scan;
}

Scan load_scan(const fs::path& path, const ScanChanges& changes) {
  ScanFiles files = scan_files_in(path, changes);
  return files.further_cameras.empty() ? load_scan(files) : load_cameras(std::move(files), changes);
}

std::vector<BoardScans> board_scans(const fs::path& folder, const ScanChanges& changes,
                                    Axis first_axis) {
  throw_if(!fs::is_directory(folder),
           "{}: no such folder; expected a folder with a subfolder for each pose", folder.string());

  if (has_both_axes(folder)) return {pose_in(folder, changes, first_axis)};

  std::vector<fs::path> folders;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.is_directory() && is_scan_folder(entry.path())) folders.push_back(entry.path());
  }

  std::ranges::sort(folders, before_in_order);
  throw_if(folders.empty(), "{}: no subfolders; expected one for each pose of the board",
           folder.string());

  std::vector<BoardScans> poses;
  poses.reserve(folders.size());
  for (const fs::path& pose : folders) poses.push_back(pose_in(pose, changes, first_axis));

  return poses;
}

ScanFiles save_scan(const fs::path& path, const FrameViews& frames, const Sequence& sequence,
                    const SavedParts& parts) {
  const auto& [scanner, scanner_file, in_colour, white, temperatures] = parts;
  require_as_taken(sequence.strategy);
  if (in_colour) require_in_colour(sequence, path.string());

  // 1. A recording holds everything in one file.
  if (lower_case_extension(path) == ".slip") {
    save_recording(path, frames,
                   {.format = {},
                    .sequence = sequence,
                    .scanner = scanner_file ? read_scanner(*scanner_file) : scanner,
                    .in_colour = in_colour,
                    .white = white,
                    .temperatures = temperatures});
    return scan_files_in(path);
  }

  // 2. A folder: its frames, as 8- or 16-bit PNG or, unquantised, float TIFF.
  make_folder(path);
  ScanFiles files{.path = path,
                  .described = true,
                  .sequence = sequence,
                  .bits = frames.quantised() ? frames.bits() : 0,
                  .temperatures = temperatures,
                  .scanner = scanner_file};

  const char* const ending = frames.quantised() ? "png" : "tiff";
  for (int n = 0; n < frames.count(); ++n) {
    files.frames.push_back(path / fmt::format("frame_{:02}.{}", n, ending));
  }

  if (in_colour) {
    files.frames.resize(files.frames.size() / 3);
    write_colour_frames(files.frames, frames);
    if (white.count() != 0) {
      files.white = path / "white.png";
      write_colour_frames({*files.white}, white);
    }
  } else {
    write_frames(files.frames, frames);
  }

  // 3. The scanner, unless it is a file already, and the description.
  if (scanner && !scanner_file) {
    files.scanner = path / "scanner.yaml";
    write_scanner(*files.scanner, *scanner);
  }
  write_scan_files(path / "scan.yaml", files);

  remove_other_frames(path, files.frames);
  return files;
}

void save_guard(ScanFiles& scan, const FrameViews& frames, const Sequence& guard) {
  scan.guard = scan.path / "guard";
  save_scan(*scan.guard, frames, guard, {.scanner_file = scan.scanner});
  write_scan_files(scan.path / "scan.yaml", scan);
}

fs::path path_named_by_time(const fs::path& parent, std::string_view what,
                            std::string_view ending) {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  return free_path(parent /
                   fmt::format("{}-{:%Y%m%d-%H%M%S}{}", what, fmt::localtime(now), ending));
}

std::uint32_t checksum_of(const ScanFiles& scan) {
  // A single further camera counts as in the manifests of earlier versions.
  std::uint32_t sum = 0;
  for (std::size_t i = scan.further_cameras.size(); i > 0; --i) {
    sum = std::rotl(sum, 1) ^ checksum_of(scan_files_in(scan.further_cameras[i - 1]));
  }
  if (scan.guard) {
    const ScanFiles guard = scan_files_in(*scan.guard);
    sum ^= checksum_of(ScanFiles{.path = guard.path,
                                 .sequence = guard.sequence,
                                 .frames = guard.frames,
                                 .recording = guard.recording});
  }
  if (scan.recording) sum = cycle_checksum(*scan.recording, scan.sequence, scan.window, sum);

  // Each file once, though it may have several pages.
  std::vector<fs::path> files;
  for (const fs::path& frame : scan.frames) {
    if (files.empty() || files.back() != file_of_page(frame)) files.push_back(file_of_page(frame));
  }

  if (scan.white) files.push_back(*scan.white);
  add_scanner_files(scan.colour_scanner, files);
  files.insert(files.end(), scan.colour.begin(), scan.colour.end());
  if (fs::exists(scan.path / "scan.yaml")) files.push_back(scan.path / "scan.yaml");
  add_scanner_files(scan.scanner, files);

  for (const fs::path& file : files) {  // of recordings the header
    sum = scan.recording && file == scan.path ? scan.recording->checksum(0, 0, sum)
          : is_recording(file)                ? RecordingReader(file).checksum(0, 0, sum)
                                              : checksum_of_file(file, sum);
  }

  return sum;
}

}  // namespace slipstream
