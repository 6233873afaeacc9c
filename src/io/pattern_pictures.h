#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "slipstream/pattern_set.h"
#include "slipstream/sequence.h"

namespace slipstream {

/// Path of pattern n, from 0, in a folder of patterns: pattern_00.png, pattern_01.png, ...
std::filesystem::path pattern_file(const std::filesystem::path& folder, std::size_t n);

/// Writes patterns as pictures for a projector with `bits` bits, named by pattern_file, into a new
/// folder, with a scan.yaml that describes `sequence` (without the marker, which is not a frame of
/// the scan). Calls `written` after each picture; returns their paths. Throws Error for unsupported
/// bits.
std::vector<std::filesystem::path> write_patterns(const std::filesystem::path& folder,
                                                  const PatternSet& patterns,
                                                  const Sequence& sequence, int bits,
                                                  const std::function<void()>& written);

/// The same in colour: three patterns per 8-bit picture, a white picture, and the pictures for
/// `calibrate colour`. Throws Error unless the patterns are a multiple of
/// three, and for binary patterns or a marker.
std::vector<std::filesystem::path> write_colour_patterns(const std::filesystem::path& folder,
                                                         const PatternSet& patterns,
                                                         const Sequence& sequence,
                                                         const std::function<void()>& written);

/// Writes one PNG with a strip for each pattern from top to bottom, the projector coordinate from
/// left to right over `length` pixels. Throws Error for another ending.
void write_pattern_sheet(const std::filesystem::path& file, const PatternSet& patterns, int length);

/// A camera's intensities of uniform patterns.
struct UniformLevels {
  std::vector<double> values{};       ///< of the patterns, [0, 1]
  std::vector<double> intensities{};  ///< grey levels of 255
};

/// Reads pictures of uniform patterns in a folder, each named by its grey level of 255, as
/// level_017.png: the mean over the centre of each, where the light is uniform. Throws Error if one
/// has no level in its name or is saturated.
UniformLevels read_uniform_pictures(const std::filesystem::path& folder);

/// Writes `count` uniform pictures, 2 to 256, with grey levels from 0 to 255 in equal steps, to a
/// new folder under such names. Returns their paths.
std::vector<std::filesystem::path> write_uniform_pictures(const std::filesystem::path& folder,
                                                          Size size, int count);

}  // namespace slipstream
