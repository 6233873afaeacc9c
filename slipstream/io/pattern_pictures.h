#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "slipstream/codes/pattern_set.h"
#include "slipstream/codes/sequence.h"

namespace slipstream {

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

}  // namespace slipstream
