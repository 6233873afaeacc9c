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

/// How long things took, ms; 0 where nothing has been measured yet.
struct Latency {
  double p50 = 0;
  double p99 = 0;
  double max = 0;
};

/// One of the threads that the data passes.
struct StageStatistics {
  std::string name;          ///< "capture", "window", "reconstruct", "show"
  std::uint64_t done = 0;    ///< what it has finished
  double rate = 0;           ///< per second, over the last second
  std::size_t waiting = 0;   ///< in the queue before it
  std::size_t capacity = 0;  ///< of that queue
  Latency latency;           ///< from a frame's capture to the end of this stage
};

/// How a model of the clouds comes on.
struct ModelStatistics {
  int views = 0;             ///< taken in
  int left_out = 0;          ///< that did not fit
  std::uint64_t missed = 0;  ///< that came while another was taken in
  std::size_t points = 0;    ///< of the model, sure or not
  double rms = 0;            ///< of the last view from the model, mm
  double milliseconds = 0;   ///< that a view took, on average
};

/// A line for people.
std::string text_of(const ModelStatistics& model);

/// Measured all the time; the counts are from the start.
struct LiveStatistics {
  struct Frames {
    std::uint64_t captured = 0;     ///< came whole, each counted once
    std::uint64_t lost = 0;         ///< gaps in the sequence and damaged frames
    std::uint64_t overwritten = 0;  ///< came whole, but nobody had time for them
    std::uint64_t repeated = 0;     ///< came again, or too late to be put in order
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
  std::vector<Finding>
      findings;  ///< about the newest cycle that was looked at; empty: all is right
};

/// Lines for people: frames, clouds, latency, what cleaning took, what is followed.
std::string text_of(const LiveStatistics& statistics);

}  // namespace slipstream
