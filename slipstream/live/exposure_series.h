#pragma once

#include <string>
#include <vector>

#include "slipstream/codes/sequence.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/frames/frame_source.h"

namespace slipstream {

/// The frames of one cycle of a source that shows the sequence over and over, in pattern order; the
/// source is started and stopped. Throws WorldError, naming `source`, where none comes whole.
FrameSet take_window(FrameSource& frames, const Sequence& sequence, const std::string& source);

/// Frame sets of one format, one behind another. Throws Error where they differ.
FrameSet joined(const std::vector<FrameSet>& sets);

}  // namespace slipstream
