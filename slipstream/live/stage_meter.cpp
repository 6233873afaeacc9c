#include "slipstream/live/stage_meter.h"

#include <algorithm>

namespace slipstream {

std::int64_t StageMeter::slot_number(Clock::time_point time) const {
  return (time - start_) / (std::chrono::nanoseconds(std::chrono::seconds(1)) / slots_per_second);
}

void StageMeter::done(Clock::time_point captured) {
  const Clock::time_point now = Clock::now();
  const std::int64_t number = slot_number(now);
  Slot& slot = slots_[static_cast<std::size_t>(number) % slots_.size()];
  if (slot.number.load(std::memory_order_relaxed) != number) {
    slot.count.store(0, std::memory_order_relaxed);
    slot.number.store(number, std::memory_order_relaxed);
  }
  slot.count.fetch_add(1, std::memory_order_relaxed);
  count_.fetch_add(1, std::memory_order_relaxed);
  latency_.add(now - captured);
}

StageStatistics StageMeter::statistics(Clock::time_point then) const {
  const std::int64_t now = slot_number(then);
  const std::int64_t whole = std::min(now, slots_per_second);
  std::uint64_t last_second = 0;
  for (const Slot& slot : slots_) {
    const std::int64_t number = slot.number.load(std::memory_order_relaxed);
    if (number >= now - whole && number < now) {
      last_second += slot.count.load(std::memory_order_relaxed);
    }
  }
  StageStatistics statistics;
  statistics.done = count();
  if (whole > 0) {
    statistics.rate =
        static_cast<double>(last_second * slots_per_second) / static_cast<double>(whole);
  }
  statistics.latency = latency_.latency();
  return statistics;
}

}  // namespace slipstream
