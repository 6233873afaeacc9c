#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "slipstream/live/live_statistics.h"

namespace slipstream {

/// Counts durations from 1 us to 100 s in steps of 4 %, in fixed memory. One thread adds, any may
/// ask; percentiles are the upper ends of their steps, never more than the maximum, which is exact.
class LatencyHistogram {
 public:
  void add(std::chrono::nanoseconds duration);
  [[nodiscard]] Latency latency() const;

 private:
  static constexpr std::size_t steps_per_decade = 58;
  static constexpr std::size_t steps = 8 * steps_per_decade + 1;

  std::array<std::atomic<std::uint64_t>, steps> counts_{};
  std::atomic<std::int64_t> longest_ = 0;  ///< ns
};

}  // namespace slipstream
