#pragma once

#include <filesystem>

#include "slipstream/codes/pattern_set.h"
#include "slipstream/codes/sequence.h"
#include "slipstream/frames/frame_source.h"

namespace slipstream {

/// Where pattern n, from 0, is written in a folder of patterns: pattern_00.png, pattern_01.png, ...
std::filesystem::path pattern_file(const std::filesystem::path& folder, std::size_t n);

/// Writes patterns as pictures for a projector of that many bits, as pattern_file names them, into
/// a folder, which is made, and a scan.yaml that says that they show `sequence`: all but the
/// marker, which is no frame of the scan. Returns the pictures; `written` is called after each.
/// Throws Error for bits that no projector has.
std::vector<std::filesystem::path> write_patterns(const std::filesystem::path& folder,
                                                  const PatternSet& patterns,
                                                  const Sequence& sequence, int bits,
                                                  const std::function<void()>& written);

/// The same in colour: three patterns to a picture, of 8 bits; beside them a white one, and those
/// that `calibrate colour` wants of a white surface, by their names in primaries.h. Throws Error
/// for patterns that are not a multiple of three, binary ones and a marker.
std::vector<std::filesystem::path> write_colour_patterns(const std::filesystem::path& folder,
                                                         const PatternSet& patterns,
                                                         const Sequence& sequence,
                                                         const std::function<void()>& written);

/// Writes one PNG of all patterns, a strip for each from the first on downwards, the projector
/// coordinate from left to right, `length` pixels. Throws Error for another ending.
void write_pattern_sheet(const std::filesystem::path& file, const PatternSet& patterns, int length);

/// What a camera saw of uniform patterns.
struct UniformLevels {
  std::vector<double> values{};       ///< of the patterns, [0, 1]
  std::vector<double> intensities{};  ///< grey levels of 255
};

/// The pictures of uniform patterns in a folder, each named by its grey level of 255, as
/// level_017.png: the mean over the middle of each, where the light is even. Throws Error where one
/// has no level in its name or is saturated.
UniformLevels read_uniform_pictures(const std::filesystem::path& folder);

/// Writes `count` pictures, 2 to 256, of that size and of one grey level each, from 0 to 255 in
/// even steps, into a folder, which is made, under such names. Returns them.
std::vector<std::filesystem::path> write_uniform_pictures(const std::filesystem::path& folder,
                                                          Size size, int count);

}  // namespace slipstream
