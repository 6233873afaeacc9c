#include "slipstream/codes/micro_phase_shifting.h"

#include <cstddef>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/sinusoid.h"

namespace slipstream {
namespace {

constexpr int steps = 3;

}  // namespace

void MicroPhaseShifting::require_valid() const {
  constexpr std::size_t most = 64;
  if (periods.size() < 2 || periods.size() > most) {
    throw Error(fmt::format("micro: {} periods are given; 2 to {}", periods.size(), most));
  }
  for (const double frequency : periods) slipstream::require_valid(Sinusoid{3, frequency}, "micro");
}

double MicroPhaseShifting::shape(int n, double y) const {
  if (n < steps) return sinusoid_intensity({steps, periods.front(), shifts}, n, y);
  return sinusoid_intensity({steps, periods[static_cast<std::size_t>(n - steps + 1)], shifts}, 0,
                            y);
}

Layout MicroPhaseShifting::layout() const {
  const int frames = steps + static_cast<int>(periods.size()) - 1;
  Layout layout{.frames = frames,
                .bands = {phase_shifted_band(frames, 0, steps, periods.front(), 1, 1, shifts)},
                .unwrapping = Unwrapping::single_frames};
  for (std::size_t i = 1; i < periods.size(); ++i) {
    layout.single_frames.push_back({steps + static_cast<int>(i) - 1, periods[i], shifts.origin});
  }
  return layout;
}

}  // namespace slipstream
