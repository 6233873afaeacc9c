#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "slipstream/live/latency_histogram.h"
#include "slipstream/live/live_statistics.h"

namespace slipstream {

/// What one stage has done, how fast and how late, in fixed memory. The stage's thread counts, any
/// may ask.
class StageMeter {
 public:
  using Clock = std::chrono::steady_clock;

  /// One more is done now, of a frame captured then.
  void done(Clock::time_point captured);

  [[nodiscard]] std::uint64_t count() const { return count_.load(std::memory_order_relaxed); }
  /// As it stood then; name and queue are left to the caller.
  [[nodiscard]] StageStatistics statistics(Clock::time_point then) const;

 private:
  /// A second is divided into slots; the one that is being filled is left out of the rate.
  static constexpr std::int64_t slots_per_second = 10;
  struct Slot {
    std::atomic<std::int64_t> number = -1;
    std::atomic<std::uint64_t> count = 0;
  };

  [[nodiscard]] std::int64_t slot_number(Clock::time_point time) const;

  Clock::time_point start_ = Clock::now();
  std::array<Slot, 2 * slots_per_second> slots_;
  std::atomic<std::uint64_t> count_ = 0;
  LatencyHistogram latency_;
};

}  // namespace slipstream
