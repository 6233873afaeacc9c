#pragma once

#include <array>
#include <atomic>
#include <bitset>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "slipstream/check.h"
#include "slipstream/live_pipeline.h"

// Counters of a live run; all except the diagnostics have fixed memory.
namespace slipstream {

/// Histogram of durations, 1 us to 100 s in steps of 4 %; percentiles are upper ends of steps, the
/// maximum is exact. One thread adds, any may query.
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

/// Throughput and latency of one stage. The stage's thread counts, any may query.
class StageMeter {
 public:
  using Clock = std::chrono::steady_clock;

  /// Counts an item finished now, from a frame captured at `captured`.
  void done(Clock::time_point captured);

  [[nodiscard]] std::uint64_t count() const { return count_.load(std::memory_order_relaxed); }
  /// At time `then`; the caller sets name and queue.
  [[nodiscard]] StageStatistics statistics(Clock::time_point then) const;

 private:
  /// A second is divided into slots; the rate does not count the slot being filled.
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

/// Counts the frames missing in the sequence of a source.
class SequenceWatch {
 public:
  /// How far back a frame counts as late, not as a restart.
  static constexpr std::uint64_t memory = 64;

  /// Returns false for a frame received before.
  bool look(std::uint64_t sequence);
  /// Call for a damaged frame. Its number counts as lost, unless the next gap contains it.
  void damaged() { ++damaged_; }

  /// Frames missing so far, without those that came late.
  [[nodiscard]] std::uint64_t lost() const { return lost_ + damaged_; }
  /// How often the source restarted its count.
  [[nodiscard]] std::uint64_t restarts() const { return restarts_; }

 private:
  std::bitset<memory> seen_;  ///< bit i: expected_ - 1 - i
  bool begun_ = false;
  std::uint64_t expected_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t damaged_ = 0;  ///< since the last frame
  std::uint64_t restarts_ = 0;
};

/// When diagnostics began and ended; those with the same `what` are one. Allocates nothing while
/// there are none.
class FindingLog {
 public:
  /// Beyond this, the oldest that have ended are dropped.
  static constexpr std::size_t most = 256;

  /// Replaces the diagnostics of the previous check.
  void replace(std::vector<Finding> findings, std::uint64_t sequence);

  /// From the newest check.
  [[nodiscard]] const std::vector<Finding>& current() const { return current_; }
  /// All, in the order in which they began.
  [[nodiscard]] const std::vector<LiveFinding>& all() const { return found_; }

 private:
  std::vector<Finding> current_;
  std::vector<LiveFinding> found_;
};

}  // namespace slipstream
