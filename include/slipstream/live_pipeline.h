#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/check.h"
#include "slipstream/cloud.h"
#include "slipstream/engine.h"
#include "slipstream/frame_source.h"
#include "slipstream/measure.h"
#include "slipstream/sequence.h"
#include "slipstream/surface.h"

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

struct FusedModel;

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
  std::uint64_t reconnects = 0;          ///< SourceCounters::reconnects
  /// Pixels of the newest cloud that cleaning rejected, by reason; `valid`: its points.
  ValidityCounts cleaned{};
  int motion = 0;                ///< of the newest cloud: see LiveCloud
  double seconds = 0;            ///< since the start
  double clouds_per_second = 0;  ///< since the start
  Latency latency;               ///< from capture to cloud
  Latency screen_latency;        ///< from capture to screen; zeros without a screen
  std::vector<StageStatistics> stages;
  std::string source_state;  ///< FrameSource::state
  /// Engine::backend_for the newest cloud, "matched cameras" or "fused cameras"; empty before it.
  std::string backend;
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
    visit("reconnects", reconnects, "camera found again");
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

/// Cloud of one window of frames, with its frames.
struct LiveCloud {
  Cloud cloud;               ///< empty without a scanner
  ValidityCounts cleaned{};  ///< points that cleaning removed, by reason
  /// With LiveSettings::fuse, the points of both cameras in the first one's frame, and the same as
  /// a cloud of one row; `cloud` has those of the first camera. Null and empty if a camera measures
  /// too few.
  std::shared_ptr<const FusedModel> fused;
  Cloud fused_points;
  /// The window, in the order given by PatternWindows; frames as captured.
  std::vector<Pooled<Frame>> frames;
  std::shared_ptr<const Sequence> sequence;  ///< of the frames
  int first_pattern = 0;                     ///< index of the first frame's pattern
  int motion = 0;                            ///< frames beyond one cycle used for the cloud
  FrameStamp newest;                         ///< the frame that completed the window

  /// The points of both cameras if they were fused.
  [[nodiscard]] const Cloud& points() const { return fused ? fused_points : cloud; }
};

/// Settings of a LivePipeline.
struct LiveSettings {
  PatternIndexing indexing = PatternIndexing::source;
  /// Captured frames that may wait if the source has its own pace; beyond that, the oldest is lost.
  std::size_t waiting_frames = 16;
  /// Clouds that consumers may hold without blocking the pipeline.
  std::size_t held_clouds = 4;
  /// With motion frames: a window with little motion becomes a cloud of its middle cycle alone.
  bool motion_when_seen = false;
  /// Capture ends after this many frames.
  std::optional<std::uint64_t> most_frames = {};
  /// The frames carry pictures of a second camera, see PairedSource, and clouds come from matches
  /// between both, see PhaseMatcher: this camera with the same projector.
  std::optional<Scanner> second_camera = {};
  /// With it, fuses the points that each camera measures with the projector: see
  /// ScanJobSettings::fuse. reconstruct() gives the same cloud of a scan of the window. It is
  /// empty, with a diagnostic, if a camera measures too little.
  bool fuse = false;
  /// Colours of the camera's pixels, which do not change, as of a replayed scan; empty if unknown.
  Image<Colour> colour = {};
  /// Called for every cloud, in order, in the thread of the show stage; meanwhile clouds and frames
  /// queue up. An exception ends the pipeline.
  std::function<void(const Pooled<LiveCloud>&)> on_cloud = {};
  /// Shape to track in the clouds, and whether to merge them into a model of a rigid object. Each
  /// runs in its own thread and skips clouds that arrive while it is busy.
  std::optional<TrackedShape> track = {};
  bool model = false;
  /// Checks one window per cycle, in pattern order, and returns diagnostics; LiveCheck if empty.
  /// Called in the thread of the reconstruct stage, which waits for it.
  std::function<std::vector<Finding>(const FrameViews& window)> check = {};
};

class ChangeSignal;
class LiveRun;
struct WindowEngine;

/// From a source to live clouds: capture, window, reconstruct and show, each in its own thread with
/// a bounded queue before it. Each new frame gives a cloud of the N newest. A source with its own
/// pace never waits: if later stages are too slow, whole windows are skipped and counted, and
/// frames without room are overwritten and counted. Allocates all memory at the start. Without a
/// scanner (see without_geometry) frames are only checked and passed on.
///
/// One thread starts, stops and changes it; any thread may query it.
class LivePipeline {
 public:
  /// Does not start. Throws Error if scanner, strategy or settings are invalid or do not match
  /// frames.
  LivePipeline(std::unique_ptr<FrameSource> source, const EngineSetup& setup,
               const LiveSettings& settings = {});
  ~LivePipeline() { stop(); }

  /// Throws as the source does. Resets all counts.
  void start();
  /// Finishes captured frames if consumers release clouds. May be called twice; restart by start().
  void stop();
  /// True if started and not stopped, the source has not ended and no stage has failed.
  [[nodiscard]] bool running() const;

  /// Blocks until running() is false. Frames captured before that may still become clouds: stop()
  /// waits for them.
  void wait() const;
  /// Exception of a stage, the source or a consumer that ended the pipeline; null if there is none.
  [[nodiscard]] std::exception_ptr failure() const;

  /// Sets settings, strategy and scanner from the next window on. Throws as the constructor does.
  void change(const EngineSetup& setup);

  /// Newest cloud whose window begins with the first pattern, for display; empty before the first.
  /// May be kept while it is shown; capture does not wait for it.
  [[nodiscard]] Pooled<LiveCloud> newest() const;
  /// Call from one thread when a cloud is on screen; `captured`: host_time of its newest frame.
  void shown(std::chrono::steady_clock::time_point captured);

  [[nodiscard]] LiveStatistics statistics() const;
  /// Model of the clouds since the start; no points unless the settings ask for one.
  [[nodiscard]] ModelPoints model() const;
  /// Diagnostics of the frames since the start; LiveStatistics has the current ones. One window per
  /// cycle is checked, before it is shown.
  [[nodiscard]] std::vector<LiveFinding> findings() const;

 private:
  [[nodiscard]] std::shared_ptr<WindowEngine> plan_for(const EngineSetup& setup);
  [[nodiscard]] std::shared_ptr<LiveRun> run() const;
  /// Queries the last run; an empty answer before the first.
  template <class Answer>
  Answer answer_of(Answer (LiveRun::*question)() const) const;

  std::unique_ptr<FrameSource> source_;
  FrameFormat format_;
  LiveSettings settings_;
  std::shared_ptr<ChangeSignal> changes_;  ///< announces values that return to the pools
  std::shared_ptr<Pool<Frame>> frames_;
  std::size_t frame_count_ = 0;  ///< size of the pool
  std::shared_ptr<Pool<LiveCloud>> clouds_;
  std::shared_ptr<WindowEngine> plan_;
  bool started_ = false;
  mutable std::mutex mutex_;      ///< guards `run_`
  std::shared_ptr<LiveRun> run_;  ///< the last one, stopped or not
};

}  // namespace slipstream
