#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/check/finding.h"
#include "slipstream/cloud/cloud.h"
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

  /// See LiveStatistics::for_each_figure.
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

  /// See LiveStatistics::for_each_figure.
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

    /// See LiveStatistics::for_each_figure.
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
  /// How many points cleaning took from the newest cloud, by reason, and at `valid` how many gaps
  /// it filled.
  ValidityCounts cleaned{};
  int motion = 0;                ///< of the newest cloud: see LiveCloud
  double seconds = 0;            ///< since the start
  double clouds_per_second = 0;  ///< over the whole time
  Latency latency;               ///< from capture to cloud
  Latency screen_latency;        ///< from capture to screen; zeros without one
  std::vector<StageStatistics> stages;
  std::string source_state;          ///< FrameSource::state
  std::string backend;               ///< Engine::backend_for the newest cloud; empty before it
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

}  // namespace slipstream
