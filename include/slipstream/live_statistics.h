#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/check.h"
#include "slipstream/measure.h"

namespace slipstream {

/// Known shape to find in every cloud: a sphere, or the plane with the most points.
struct TrackedShape {
  std::optional<double> radius{};  ///< of the sphere, mm; nullopt: a plane
};

/// Parses "sphere:RADIUS" or "plane". Throws Error for anything else.
TrackedShape tracked_shape_named(std::string_view name);

/// Position of a shape in the last cloud that contained it.
struct ObjectTrack {
  TrackedShape shape{};
  std::uint64_t found = 0;   ///< clouds that contained it
  std::uint64_t looked = 0;  ///< clouds searched
  std::uint64_t missed = 0;  ///< clouds skipped while another was searched
  /// Centre of the sphere, or intersection of the plane with the camera's axis, mm.
  Eigen::Vector3d place = Eigen::Vector3d::Zero();
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();  ///< plane, towards the camera; else zero
  Residuals residuals{};
  /// mm/s, from the last clouds; along the normal of a plane. Zero before the third cloud.
  Eigen::Vector3d velocity = Eigen::Vector3d::Zero();

  template <class Visit>
  void for_each_figure(const Visit& visit) const {
    visit("found", found);
    visit("looked", looked);
    visit("missed", missed);
    visit(shape.radius ? "centre_mm" : "place_mm", place);
    visit("residual_mm", residuals.rms);
    visit("points", residuals.points);
    visit("velocity_mm_per_s", velocity);
    visit("speed_mm_per_s", velocity.norm());
    if (!shape.radius) visit("normal", normal);
  }
};

/// Progress of a model built from the clouds.
struct ModelStatistics {
  int views = 0;             ///< merged
  int left_out = 0;          ///< rejected because they did not fit
  std::uint64_t missed = 0;  ///< skipped while another was merged
  std::size_t points = 0;    ///< of the model, confirmed or not
  double rms = 0;            ///< distance of the last view from the model, mm
  double milliseconds = 0;   ///< per view, on average

  template <class Visit>
  void for_each_figure(const Visit& visit) const {
    visit("views", views);
    visit("left_out", left_out);
    visit("missed", missed);
    visit("points", points);
    visit("rms_mm", rms);
    visit("view_ms", milliseconds);
  }
};

/// One line for people.
std::string text_of(const ObjectTrack& track);
std::string text_of(const ModelStatistics& model);

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

}  // namespace slipstream
