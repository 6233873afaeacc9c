#pragma once

#include <cstdint>
#include <limits>

namespace slipstream {

// The most that is read of a file, whatever it says of itself, looked at before memory is taken.
// docs/limits.md states them.

/// Bytes of scan.yaml, a scanner file or a rig file, and of each text in a recording.
inline constexpr std::uint64_t largest_text = std::uint64_t{1} << 20;
/// Bytes of a picture's file.
inline constexpr std::uint64_t largest_picture_file = (std::uint64_t{2} << 30) - 1;
/// Bytes of a cloud's or mesh's file.
inline constexpr std::uint64_t largest_file = std::uint64_t{4} << 30;
/// Of a recording's file: it is read frame by frame.
inline constexpr std::uint64_t no_limit = std::numeric_limits<std::uint64_t>::max();
/// Pixels of a picture or of a recording's frames.
inline constexpr std::uint64_t largest_picture = 160'000'000;
/// Bytes of the pixels of all frames of a scan.
inline constexpr std::uint64_t largest_scan = std::uint64_t{4} << 30;
/// Scans of one run, by lists and ranges of windows.
inline constexpr std::uint64_t most_scans = 10'000'000;

}  // namespace slipstream
