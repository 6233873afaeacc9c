#pragma once

#include <array>
#include <atomic>
#include <bitset>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "slipstream/live/live_statistics.h"

// What a live run counts. All but findings are counted in fixed memory.
namespace slipstream {

/// Counts durations from 1 us to 100 s in steps of 4 %. One thread adds, any may ask; percentiles
/// are the upper ends of their steps, never more than the maximum, which is exact.
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

/// What one stage has done, how fast and how late. The stage's thread counts, any may ask.
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

/// Counts what is missing in the sequence of a source's frames.
class SequenceWatch {
 public:
  /// How far back a frame is taken for one that came late, not for a count begun anew.
  static constexpr std::uint64_t memory = 64;

  enum class Kind {
    fresh,     ///< after all others, or one that was missing
    repeated,  ///< this one was here
    restart,   ///< the source counts from the beginning again
  };

  Kind look(std::uint64_t sequence);
  /// A frame came that was not whole. It has taken a number of the sequence, or the next gap will
  /// not tell.
  void damaged() { ++damaged_; }

  /// Frames missing so far; one that comes late is missing no longer.
  [[nodiscard]] std::uint64_t lost() const { return lost_ + damaged_; }
  /// How often the source has counted from the beginning again.
  [[nodiscard]] std::uint64_t restarts() const { return restarts_; }

 private:
  std::bitset<memory> seen_;  ///< bit i: expected_ - 1 - i
  bool begun_ = false;
  std::uint64_t expected_ = 0;
  std::uint64_t lost_ = 0;
  std::uint64_t damaged_ = 0;  ///< since the last frame
  std::uint64_t restarts_ = 0;
};

/// When what began and ended, look by look. Findings of one `what` are the same one, though its
/// numbers change. Nothing is allocated while all is right.
class FindingLog {
 public:
  /// The oldest that have ended are forgotten where there would be more.
  static constexpr std::size_t most = 256;

  /// What a look has found takes the place of what the one before did.
  void replace(std::vector<Finding> findings, std::uint64_t sequence);

  /// By the newest look.
  [[nodiscard]] const std::vector<Finding>& current() const { return current_; }
  /// All, in the order in which they began.
  [[nodiscard]] const std::vector<LiveFinding>& told() const { return told_; }

 private:
  std::vector<Finding> current_;
  std::vector<LiveFinding> told_;
};

}  // namespace slipstream
