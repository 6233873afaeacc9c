#pragma once

#include "slipstream/cloud.h"
#include "slipstream/scan.h"
#include "slipstream/scan_folder.h"

namespace slipstream {

/// Loads the frames and sequence of a scan, with exposures merged, without the scanner (read only
/// to separate colour channels). From a recording, loads the first complete cycle. Throws Error
/// with the path if frames cannot be read or do not match the strategy's number, or for an invalid
/// order.
Scan load_frames(const ScanFiles& files);

/// Whether the files are colour pictures of three frames each.
bool is_in_colour(const ScanFiles& files);

/// Loads one camera's frames, sequence and, if `files` names it, scanner, completed and validated
/// against the frames. Throws Error if a part cannot be read or does not fit; the scanner is
/// optional.
Scan load_scan(const ScanFiles& files);

/// The same for colour pictures, neither separated nor merged; `white` receives the channels of the
/// white picture, if any. Also throws Error if an order is set.
Scan load_as_taken(const ScanFiles& files, FrameSet& white);

/// Loads the complete scan in a folder or recording, with any second camera, whose sequence must be
/// the same; see scan_files_in.
Scan load_scan(const std::filesystem::path& path, const ScanChanges& changes = {});

/// The poses in a folder, in natural order of their names. Each pose is a folder that contains
///   - scans x and y: folders, with or without scan.yaml, or recordings x.slip and y.slip; or
///   - the pictures of both scans, first along `first_axis`, in order of their names.
/// Skips folders with a report.html. A folder that contains x and y itself is the only pose. Throws
/// Error without poses, for a folder of neither kind, and as scan_files_in. Frames are read later,
/// as by load_frames.
std::vector<BoardScans> board_scans(const std::filesystem::path& folder, const ScanChanges& changes,
                                    Axis first_axis);

/// Writes a scan to a folder, instead of one that is there: frames as frame_00.png and so on (.tiff
/// if unquantised), scan.yaml, and scanner.yaml if the scanner is known, or a reference to the
/// existing `scanner_file`. If the path ends in .slip, writes a recording of one cycle.
/// `in_colour`: three frames per picture, see colour_channels.h, plus a white picture if given.
/// Returns the files.
/// Throws Error for a recording of unquantised frames, and as require_as_taken, before writing.
ScanFiles save_scan(const std::filesystem::path& path, const FrameViews& frames,
                    const Sequence& sequence, const std::optional<Scanner>& scanner,
                    const std::optional<std::filesystem::path>& scanner_file = std::nullopt,
                    bool in_colour = false, const FrameSet& white = {});

/// Checksum over all files of a scan: scan.yaml, frames, scanner file and a second camera's; for a
/// recording, its header and the frames of the window. Throws Error if one is missing.
std::uint32_t checksum_of(const ScanFiles& scan);

/// The path, with -2, -3 and so on before the ending if it exists.
std::filesystem::path free_path(const std::filesystem::path& path);

/// A free path in `parent`, named by the time: "WHAT-20260131-142530ENDING".
std::filesystem::path path_named_by_time(const std::filesystem::path& parent, std::string_view what,
                                         std::string_view ending);

/// RMS error of depth, mm, against the ground truth of a virtual scan, truth/depth.tiff, over the
/// points in both; at edges against the nearest depth around the pixel. Returns nullopt without
/// ground truth or common points. Throws Error if the sizes differ.
std::optional<double> error_against_truth(const std::filesystem::path& folder, const Cloud& cloud);

}  // namespace slipstream
