#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "slipstream/scan_files.h"

namespace slipstream {

/// The pictures of `wanted` patterns, in pattern order: all of the folder's, or those chosen by its
/// `order`, which may leave out others, such as a white picture. Throws Error for an invalid order
/// and for another number of pictures, with the settings that fit it, or the likely extra ones and
/// an order without them.
std::vector<std::filesystem::path> pattern_pictures(const ScanFiles& files, int wanted);

/// Whether `a` comes before `b` in natural order by name: board2 before board10.
bool before_in_order(const std::filesystem::path& a, const std::filesystem::path& b);

/// Whether a folder beside scans may be one: neither hidden nor a report, which has a report.html.
bool is_scan_folder(const std::filesystem::path& folder);

/// The pictures in a folder in natural order, frame_2 before frame_10: each page of a TIFF file, no
/// hidden files, and JPEGs only if all pictures are. Throws Error without a folder or pictures.
std::vector<std::filesystem::path> images_in_folder(const std::filesystem::path& folder);

}  // namespace slipstream
