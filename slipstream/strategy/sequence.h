#pragma once

#include "slipstream/image/size.h"
#include "slipstream/pattern/axis.h"
#include "slipstream/pattern/pattern_set.h"
#include "slipstream/strategy/strategy.h"

namespace slipstream {

/// What a projector shows for one scan.
struct Sequence {
  Strategy strategy{};
  Axis axis = Axis::x;
  PatternLight light{};  ///< of the patterns
  Size projector{};      ///< pixels; empty where not said
  /// Shown again and again, a dark frame after the last pattern marks where each cycle ends. It is
  /// no frame of the scan.
  bool marker = false;

  friend bool operator==(const Sequence&, const Sequence&) = default;
};

/// Frames from one scan to the next: those of the strategy, and the marker.
int cycle_length(const Sequence& sequence);

/// The patterns with the marker, where there is one, as the last.
PatternSet pattern_set(const Sequence& sequence);

/// Throws Error where the projector's size is known and cannot show the strategy.
void require_shown(const Sequence& sequence);

}  // namespace slipstream
