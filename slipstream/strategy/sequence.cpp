#include "slipstream/strategy/sequence.h"

#include <utility>

namespace slipstream {

int cycle_length(const Sequence& sequence) {
  return frame_count(sequence.strategy) + (sequence.marker ? 1 : 0);
}

PatternSet pattern_set(const Sequence& sequence) {
  PatternSet patterns = pattern_set(sequence.strategy, sequence.axis, sequence.light);
  return sequence.marker ? with_marker(std::move(patterns)) : patterns;
}

void require_shown(const Sequence& sequence) {
  if (sequence.projector == Size{}) return;
  require_resolved(sequence.strategy, length_along(sequence.axis, sequence.projector));
}

}  // namespace slipstream
