#include "slipstream/devices/swap_log.h"

#include <chrono>

#include <fmt/format.h>

namespace slipstream::monitor {

void SwapLog::add(const PatternSwap& swap) {
  if (!first_) first_ = swap.time;
  text_ += fmt::format("{},{},{:.6f}\n", swap.sequence, swap.pattern,
                       std::chrono::duration<double>(swap.time - *first_).count());
}

}  // namespace slipstream::monitor
