#pragma once

#include <optional>
#include <string>
#include <vector>

#include "slipstream/frames/frame_set.h"
#include "slipstream/io/recording.h"

namespace slipstream {

/// The frames of the first whole cycle of a recording that shows that sequence, in pattern order as
/// PatternWindows puts them. None where none of its first cycles is whole.
std::optional<FrameSet> first_cycle(const RecordingReader& recording, const Sequence& sequence);

/// Windows of a recording that shows that sequence: whole cycles one behind another, counted from
/// the first pattern on, with frames of motion the cycles that have those after them.
std::uint64_t window_count(const RecordingReader& recording, const Sequence& sequence);

/// The frames of a window, below window_count, in pattern order; none where no whole cycle begins
/// there, for frames are lost or damaged.
std::optional<FrameSet> window_at(const RecordingReader& recording, const Sequence& sequence,
                                  std::uint64_t window);

/// RecordingReader::checksum of the frames that window_at, or without a window first_cycle, looks
/// at.
std::uint32_t cycle_checksum(const RecordingReader& recording, const Sequence& sequence,
                             std::optional<std::uint64_t> window, std::uint32_t before);

/// The frames of a scan as a camera gives them, stamped with their places in it. Throws Error,
/// calling the scan `name`, where no camera gives such frames.
std::vector<Frame> frames_of(const FrameViews& scan, const std::string& name);

}  // namespace slipstream
