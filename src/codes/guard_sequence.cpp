#include "codes/guard_sequence.h"

#include "slipstream/phase_shifting.h"

namespace slipstream {

Sequence guard_sequence(const Sequence& scan) {
  Sequence guard = scan;
  guard.strategy = DualFrequency{.steps = 3, .high = 8, .low = 1};
  guard.axis = across(scan.axis);
  guard.both_axes = false;

  // What belongs to the scan's own patterns.
  guard.lengths.clear();
  guard.motion = 0;
  guard.marker = false;
  return guard;
}

bool can_be_guarded(const Sequence& scan) {
  constexpr int fewest_pixels = 64;  // of eight periods
  const int length = length_along(across(scan.axis), scan.projector);
  return !scan.both_axes && length >= fewest_pixels;
}

}  // namespace slipstream
