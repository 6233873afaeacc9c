#pragma once

#include <atomic>
#include <bitset>
#include <chrono>

#include "slipstream/finding.h"
#include "slipstream/object_track.h"

namespace slipstream {

/// A diagnostic of a live scan, and how long it lasted.
struct LiveFinding {
  Finding finding;          ///< as first reported
  std::uint64_t begin = 0;  ///< newest frame's sequence number at the first check that found it
  /// Sequence number at the first check that no longer found it; nullopt while it lasts.
  std::optional<std::uint64_t> end{};

  friend bool operator==(const LiveFinding&, const LiveFinding&) = default;
};

/// Durations, ms; 0 before the first measurement.
struct Latency {
  double p50 = 0, p99 = 0, max = 0;

  template <class Visit>
  void for_each_figure(const Visit& visit) const {
    visit("p50", p50);
    visit("p99", p99);
    visit("max", max);
  }
};

struct StageStatistics {
  std::string name;          ///< "capture", "window", "reconstruct", "show"
  std::uint64_t done = 0;    ///< items finished
  double rate = 0;           ///< per second, over the last second
  std::size_t waiting = 0;   ///< items in its queue
  std::size_t capacity = 0;  ///< of its queue
  Latency latency;           ///< from a frame's capture to the end of this stage

  template <class Visit>
  void for_each_figure(const Visit& visit) const {
    visit("name", name);
    visit("done", done);
    visit("rate", rate);
    visit("waiting", waiting);
    visit("capacity", capacity);
    visit("latency_ms", latency);
  }
};

/// Updated continuously; counts are from the start.
struct LiveStatistics {
  struct Frames {
    std::uint64_t captured = 0;     ///< arrived complete, each counted once
    std::uint64_t lost = 0;         ///< gaps in the sequence and damaged frames
    std::uint64_t overwritten = 0;  ///< arrived complete, but dropped because the queue was full
    std::uint64_t repeated = 0;     ///< arrived again, or too late to be put in order

    template <class Visit>
    void for_each_figure(const Visit& visit) const {
      visit("captured", captured);
      visit("lost", lost);
      visit("overwritten", overwritten, "frames not used");
      visit("repeated", repeated, "frames repeated");
    }
  } frames;
  std::uint64_t clouds = 0;
  std::uint64_t windows_lost = 0;        ///< without a cloud: a frame was missing or out of order
  std::uint64_t windows_skipped = 0;     ///< without a cloud, though whole: for lack of time
  std::uint64_t resynchronisations = 0;  ///< pattern indices found shifted, and corrected
  /// Pixels of the newest cloud that cleaning rejected, by reason; `valid`: its points.
  ValidityCounts cleaned{};
  int motion = 0;                ///< of the newest cloud: see LiveCloud
  double seconds = 0;            ///< since the start
  double clouds_per_second = 0;  ///< since the start
  Latency latency;               ///< from capture to cloud
  Latency screen_latency;        ///< from capture to screen; zeros without a screen
  std::vector<StageStatistics> stages;
  std::string source_state;              ///< FrameSource::state
  std::string backend;                   ///< Engine::backend_for the newest cloud; empty before it
  std::string fallback_reason;           ///< Engine::fallback_reason of the newest cloud
  std::optional<ObjectTrack> track;      ///< if requested
  std::optional<ModelStatistics> model;  ///< if requested
  /// Diagnostics of the newest cycle checked; empty: no problems found.
  std::vector<Finding> findings;

  /// The only list of the statistics; JSON, metrics and the panel are generated from it. Calls
  /// `visit(name, value)` for each figure except the findings, and for `track` and `model` if
  /// present. A name is the key in JSON and ends in its unit. A value is a number, a text,
  /// ValidityCounts, an Eigen::Vector3d, a struct with a for_each_figure of its own, or a vector of
  /// these. Counts of problems have a third argument, their label for people.
  template <class Visit>
  void for_each_figure(const Visit& visit) const {
    visit("frames", frames);
    visit("clouds", clouds);
    visit("clouds_per_second", clouds_per_second);
    visit("windows_lost", windows_lost, "scans lost");
    visit("windows_skipped", windows_skipped, "scans skipped");
    visit("resynchronisations", resynchronisations, "order set right");
    visit("cleaned", cleaned);
    visit("motion", motion);
    visit("backend", backend);
    visit("seconds", seconds);
    visit("latency_ms", latency);
    visit("screen_latency_ms", screen_latency);
    visit("stages", stages);
    visit("source_state", source_state);
    if (track) visit("track", *track);
    if (model) visit("model", *model);
  }
};

/// Text for people: frames, clouds, latency, cleaning, tracked shape and model.
std::string text_of(const LiveStatistics& statistics);

// Counters of a live run; all except the diagnostics have fixed memory.

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
  [[nodiscard]] const std::vector<LiveFinding>& told() const { return told_; }

 private:
  std::vector<Finding> current_;
  std::vector<LiveFinding> told_;
};

}  // namespace slipstream
