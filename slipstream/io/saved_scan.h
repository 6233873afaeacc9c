#pragma once

#include "slipstream/cloud/cloud.h"
#include "slipstream/decode/maps.h"
#include "slipstream/geometry/scan.h"
#include "slipstream/io/scan_folder.h"

namespace slipstream {

/// The frames of a scan, several exposures merged, and what they show, without its scanner, which
/// is read where pictures in colour are to be taken apart; of a recording those of its first whole
/// cycle. Throws Error, naming folder or recording, where they cannot be read, are not as many as
/// the strategy's or its order is none of so many.
Scan load_frames(const ScanFiles& files);

/// Whether they are pictures in colour, each of three frames.
bool is_in_colour(const ScanFiles& files);

/// What one camera took: frames, sequence and the scanner that `files` names, completed by what
/// else is known and checked against it. Throws Error where anything of it cannot be read or does
/// not fit together; a scan without scanner is no error.
Scan load_scan(const ScanFiles& files);

/// The same of pictures in colour, neither taken apart nor merged, and the channels of the white
/// one where there is one. Throws Error as well where an order is asked for.
Scan load_as_taken(const ScanFiles& files, FrameSet& white);

/// Adds what a further camera took of the same patterns at the same time. Throws Error as well
/// where it was told of others.
void add_camera(Scan& scan, const ScanFiles& files);

/// The whole scan in a folder or a recording, that of a second camera with it; see scan_files_in.
Scan load_scan(const std::filesystem::path& path, const ScanChanges& changes = {});

/// Writes a scan into a folder, which is made: its frames as frame_00.png and so on, .tiff where
/// they are not quantised, scan.yaml, and scanner.yaml where the scanner is known, or
/// `scanner_file` in its place, which is there already; or, where the path ends in .slip, as a
/// recording of one cycle. `in_colour`: three frames to a picture, see colour_channels.h, and those
/// of a white one where there is one. Returns what that says. Throws Error for a recording of
/// unquantised frames, and as require_as_taken, before anything is written.
ScanFiles save_scan(const std::filesystem::path& path, const FrameViews& frames,
                    const Sequence& sequence, const std::optional<Scanner>& scanner,
                    const std::optional<std::filesystem::path>& scanner_file = std::nullopt,
                    bool in_colour = false, const FrameSet& white = {});

/// One checksum of all files that a scan consists of: scan.yaml, frames, scanner file, those of a
/// second camera; of a recording its header and the frames of the window. Throws Error where one is
/// missing.
std::uint32_t checksum_of(const ScanFiles& scan);

/// The path, with -2, -3 and so on before the ending where it is there already.
std::filesystem::path free_path(const std::filesystem::path& path);

/// One in `parent`, named by the time: "WHAT-20260131-142530ENDING".
std::filesystem::path path_named_by_time(const std::filesystem::path& parent, std::string_view what,
                                         std::string_view ending);

/// RMS of depth minus the truth that the virtual scanner wrote beside a scan, truth/depth.tiff,
/// over the points that have both, mm, at edges minus the nearest of those about the pixel; none
/// where there is no truth or no such point. Throws Error where it is of another size.
std::optional<double> error_against_truth(const std::filesystem::path& folder, const Cloud& cloud);

}  // namespace slipstream
