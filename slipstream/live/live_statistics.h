#pragma once

#include <atomic>
#include <bitset>
#include <chrono>

#include "slipstream/check/finding.h"
#include "slipstream/live/object_track.h"

namespace slipstream {

/// A finding of a live scan, from the frame on at which it was first told.
struct LiveFinding {
  Finding finding;          ///< as it was told first
  std::uint64_t begin = 0;  ///< sequence of the newest frame that was looked at then
  /// That of the first look that did not find it again; none while it lasts.
  std::optional<std::uint64_t> end{};

  friend bool operator==(const LiveFinding&, const LiveFinding&) = default;
};

/// How long things took, ms; 0 where nothing has been measured yet.
struct Latency {
  double p50 = 0;
  double p99 = 0;
  double max = 0;

  template <class Visit>
  void for_each_figure(const Visit& visit) const {
    visit("p50", p50);
    visit("p99", p99);
    visit("max", max);
  }
};

/// One of the threads that the data passes.
struct StageStatistics {
  std::string name;          ///< "capture", "window", "reconstruct", "show"
  std::uint64_t done = 0;    ///< what it has finished
  double rate = 0;           ///< per second, over the last second
  std::size_t waiting = 0;   ///< in the queue before it
  std::size_t capacity = 0;  ///< of that queue
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

/// Measured all the time; the counts are from the start.
struct LiveStatistics {
  struct Frames {
    std::uint64_t captured = 0;     ///< came whole, each counted once
    std::uint64_t lost = 0;         ///< gaps in the sequence and damaged frames
    std::uint64_t overwritten = 0;  ///< came whole, but nobody had time for them
    std::uint64_t repeated = 0;     ///< came again, or too late to be put in order

    template <class Visit>
    void for_each_figure(const Visit& visit) const {
      visit("captured", captured);
      visit("lost", lost);
      visit("overwritten", overwritten, "frames not used");
      visit("repeated", repeated, "frames repeated");
    }
  } frames;
  std::uint64_t clouds = 0;
  std::uint64_t windows_lost = 0;        ///< without a cloud: a frame was missing or slipped
  std::uint64_t resynchronisations = 0;  ///< pattern indices found slipped, and set right
  /// Points of the newest cloud that cleaning rejected, by reason; at `valid` the gaps it filled.
  ValidityCounts cleaned{};
  int motion = 0;                ///< of the newest cloud: see LiveCloud
  double seconds = 0;            ///< since the start
  double clouds_per_second = 0;  ///< over the whole time
  Latency latency;               ///< from capture to cloud
  Latency screen_latency;        ///< from capture to screen; zeros without one
  std::vector<StageStatistics> stages;
  std::string source_state;          ///< FrameSource::state
  std::string backend;               ///< Engine::backend_for the newest cloud; empty before it
  std::string fallback_reason;       ///< Engine::fallback_reason of the newest cloud
  std::optional<ObjectTrack> track;  ///< where one is asked for, as the next
  std::optional<ModelStatistics> model;
  /// About the newest cycle that was looked at; empty: all is right.
  std::vector<Finding> findings;

  /// The one description of the statistics, of which JSON, metrics and the panel are views. Calls
  /// `visit(name, value)` for each figure but the findings, `track` and `model` where there are
  /// any. A name is the key in JSON and ends in its unit. A value is a number, a text,
  /// ValidityCounts, an Eigen::Vector3d, a struct with a for_each_figure of its own, or a vector of
  /// such. A count of what goes wrong has a third argument, which says so in a row for people.
  template <class Visit>
  void for_each_figure(const Visit& visit) const {
    visit("frames", frames);
    visit("clouds", clouds);
    visit("clouds_per_second", clouds_per_second);
    visit("windows_lost", windows_lost, "scans lost");
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

/// Lines for people: frames, clouds, latency, what cleaning took, what is followed.
std::string text_of(const LiveStatistics& statistics);

// What a live run counts; all but findings in fixed memory.

/// Counts durations, 1 us to 100 s in steps of 4 %; percentiles are upper ends of steps, the
/// maximum is exact. One thread adds, any may ask.
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
  /// A damaged frame came. Its number counts as lost, unless the next gap contains it.
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

/// When findings began and ended; one `what` is one finding. Allocates nothing while there is none.
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
