#pragma once

#include <optional>
#include <vector>

#include "slipstream/codes/sequence.h"
#include "slipstream/decode/demodulator.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/frames/merged_exposures.h"
#include "slipstream/frames/pattern_windows.h"

namespace slipstream {

// Frames as a camera took them become frames as they are decoded, in one place: several exposures
// are merged, what a frame holds at once is taken apart, patterns along both axes become two scans.
// merged_sequence says what they show then. Pictures in colour come apart before, see `unmixed`.

/// The frames of one scan after another, along one axis; memory is kept.
class FrameAdapter {
 public:
  explicit FrameAdapter(const Sequence& sequence);

  /// In memory that lasts until the next call; frames that need nothing, or are adapted already, as
  /// they are. Throws Error where they are not as many as the sequence shows.
  const FrameViews& operator()(const FrameViews& taken);

 private:
  std::vector<double> exposures_;  ///< to be merged; empty for one
  int read_;                       ///< frames of the layout
  MergedFrames merged_;
  std::optional<Demodulator> demodulate_;
};

/// Whether frames of the sequence differ from those that are decoded.
bool needs_adapting(const Sequence& sequence);

/// The same for a scan that is kept: its frames, or with patterns along both axes those along x and
/// those along y.
std::vector<FrameSet> adapted(const Sequence& sequence, FrameSet taken);

/// How frames of the sequence, shown over and over, are put into windows; `scans`: so many that are
/// shown after each other in a cycle.
PatternCycle pattern_cycle(const Sequence& sequence, int scans = 1);

}  // namespace slipstream
