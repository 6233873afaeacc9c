#pragma once

#include <string_view>
#include <vector>

namespace slipstream {

/// How it is known which pattern a frame shows. Whichever it is, the pictures are watched, and a
/// slipped index is set right: see PatternWindows.
enum class PatternIndexing {
  told,     ///< by the source, FrameStamp::pattern_index; frames that lack it are counted on
  counted,  ///< the frame's sequence modulo the patterns: the projector triggers the camera
  marker,   ///< a dark or bright frame before the first pattern of each cycle of N + 1 frames
};

/// "told", "counted", "marker"; throws Error for any other name.
PatternIndexing pattern_indexing_named(std::string_view name);
std::vector<std::string_view> pattern_indexing_names();

}  // namespace slipstream
