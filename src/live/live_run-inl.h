#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <tuple>
#include <vector>

#include "base/thread_priority.h"
#include "decode/frame_adapter.h"
#include "frames/pattern_windows.h"
#include "live/bounded_queue.h"
#include "live/change_signal.h"
#include "live/followed_object-inl.h"
#include "live/live_counters.h"
#include "live/window_engine.h"

namespace slipstream {

/// Capacity of the queues between stages. One decouples the stages; more would add latency.
inline constexpr std::size_t stage_places = 1;

/// The threads of a LivePipeline from start to stop, and the queues between them.
class LiveRun {
  using Clock = std::chrono::steady_clock;

 public:
  /// `source`: started. `changes` announces each value that returns to the pools of frames and
  /// clouds. All arguments outlive this.
  LiveRun(FrameSource& source, const LiveSettings& settings, std::shared_ptr<ChangeSignal> changes,
          std::shared_ptr<Pool<LiveCloud>> clouds, std::shared_ptr<WindowEngine> plan)
      : source_(source),
        settings_(settings),
        format_(source.format()),
        paced_(source.has_own_pace()),
        changes_(std::move(changes)),
        clouds_(std::move(clouds)),
        plan_(std::move(plan)),
        captured_(paced_ ? std::max<std::size_t>(settings.waiting_frames, 1) : stage_places),
        windows_(stage_places),
        finished_(stage_places),
        followed_(settings, plan_->setup().scanner.camera,
                  [this](std::exception_ptr failure) { fail(std::move(failure)); }) {
    // One thread per stage. An exception in any of them ends the whole run.
    try {
      for (const auto stage :
           {&LiveRun::capture, &LiveRun::make_windows, &LiveRun::reconstruct, &LiveRun::show}) {
        threads_.emplace_back([this, stage] {
          try {
            (this->*stage)();
          } catch (...) {
            fail(std::current_exception());
          }
        });
      }
    } catch (...) {  // stop the threads that run already
      fail(std::current_exception());
      stop();
      throw;
    }
  }

  ~LiveRun() { stop(); }

  void stop() {
    // The stages finish the frames captured so far, each closing the queue behind it.
    stopping_ = true;
    changes_->announce();
    for (std::thread& thread : threads_) {
      if (thread.joinable()) thread.join();
    }

    followed_.finish();
    const std::lock_guard lock(mutex_);
    // From here on, rates refer to the time of the stop.
    if (!end_) end_ = Clock::now();
  }

  [[nodiscard]] bool capturing() const { return capturing_; }

  /// Returns once no more frames are captured.
  void wait() const {
    std::unique_lock lock(mutex_);
    captured_all_.wait(lock, [this] { return !capturing_; });
  }

  void change(std::shared_ptr<WindowEngine> plan) {
    const std::lock_guard lock(mutex_);
    plan_ = std::move(plan);
  }

  void shown(Clock::time_point captured) { screen_latency_.add(Clock::now() - captured); }

  [[nodiscard]] std::exception_ptr failure() const { return locked(failure_); }
  [[nodiscard]] Pooled<LiveCloud> newest() const { return locked(newest_); }
  [[nodiscard]] LiveStatistics statistics() const {
    LiveStatistics statistics;
    statistics.frames = {.captured = frames_captured_,
                         .lost = frames_lost_,
                         .overwritten = frames_overwritten_,
                         .repeated = frames_repeated_};
    statistics.clouds = show_meter_.count();
    statistics.windows_lost = windows_lost_;
    statistics.windows_skipped = windows_skipped_;
    statistics.resynchronisations = resynchronisations_;
    statistics.reconnects = source_.counters().reconnects;

    const Clock::time_point now = locked(end_).value_or(Clock::now());
    statistics.seconds = std::chrono::duration<double>(now - start_).count();
    statistics.clouds_per_second = static_cast<double>(statistics.clouds) / statistics.seconds;

    statistics.latency = cloud_latency_.latency();
    statistics.screen_latency = screen_latency_.latency();

    const auto add = [&](const char* name, const StageMeter& meter, std::size_t waiting,
                         std::size_t capacity) {
      StageStatistics& stage = statistics.stages.emplace_back(meter.statistics(now));
      stage.name = name;
      stage.waiting = waiting;
      stage.capacity = capacity;
    };
    add("capture", capture_meter_, 0, 0);
    add("window", window_meter_, captured_.waiting(), captured_.capacity());
    add("reconstruct", reconstruct_meter_, windows_.waiting(), windows_.capacity());
    add("show", show_meter_, finished_.waiting(), finished_.capacity());

    statistics.source_state = source_.state();
    followed_.add_to(statistics);
    // Everything about the newest cloud under one lock, so that it belongs together.
    Pooled<LiveCloud> newest;
    {
      const std::lock_guard lock(mutex_);

      statistics.findings = findings_.current();
      statistics.fallback_reason = fallback_reason_;
      newest = newest_;
      if (newest) statistics.backend = backend_;
    }
    if (!newest) return statistics;

    statistics.motion = newest->motion;
    statistics.cleaned = newest->cleaned;
    statistics.cleaned[static_cast<std::size_t>(Validity::valid)] = point_count(newest->points());
    return statistics;
  }

  [[nodiscard]] std::vector<LiveFinding> findings() const { return locked(findings_).all(); }
  [[nodiscard]] ModelPoints model() const { return followed_.model(); }

 private:
  /// How soon a stage notices a stop while the source is silent: a thread that waits for a device
  /// cannot be woken.
  static constexpr auto notice = std::chrono::milliseconds(50);
  /// How long to wait for clouds after a stop.
  static constexpr auto cloud_patience = std::chrono::milliseconds(200);

  struct Captured {
    Pooled<Frame> frame;
    /// Restarts of the source up to this frame; kept here as the restarting frame may be dropped.
    std::uint64_t restarts = 0;
  };
  struct Window {
    Pooled<LiveCloud> cloud;  ///< without its points
    std::shared_ptr<WindowEngine> reconstruct;
  };

  void capture() {
    if (paced_) go_when_woken();
    Frame spare(format_);  // takes frames while the pool is empty
    const auto enough = [this] {
      return settings_.most_frames && frames_captured_ >= *settings_.most_frames;
    };

    // Without the source's own pace, reading waits for room; otherwise frames are overwritten.
    while (!stopping_ && !enough() && (paced_ || captured_.wait_for_room())) {
      Pooled<Frame> frame = free_frame();
      if (!frame && !paced_) break;
      Frame& filled = frame ? frame.fill() : spare;

      Arrival arrival = source_.next(filled, notice);
      if (arrival == Arrival::ended) break;

      // A frame of another size cannot join a window.
      if (arrival == Arrival::frame && filled.format() != format_) {
        filled = Frame(format_);
        arrival = Arrival::damaged;
      }
      if (arrival == Arrival::damaged) sequence_.damaged();

      // Count gaps and repetitions by sequence number; a repeated frame is dropped.
      const bool came = arrival == Arrival::frame;
      const bool repeated = came && !sequence_.look(filled.stamp.sequence);
      frames_lost_ = sequence_.lost();
      if (repeated) ++frames_repeated_;
      if (!came || repeated) continue;

      // A frame in the spare buffer has no place in the pool and is lost.
      ++frames_captured_;
      if (!frame) ++frames_overwritten_;
      if (frame) pass_on(std::move(frame));
    }

    end_capture();
    captured_.close();
  }

  void end_capture() {
    {
      const std::lock_guard lock(mutex_);
      capturing_ = false;
    }
    captured_all_.notify_all();
  }

  /// State of make_windows from frame to frame.
  struct Windowing {
    std::shared_ptr<WindowEngine> engine{};
    std::optional<PatternWindows> windows{};
    std::uint64_t lost_before = 0, resynchronised_before = 0;  ///< totals when `windows` began
    std::uint64_t restarts = 0;                                ///< of the source
    std::vector<Pooled<Frame>> window{};                       ///< memory for the next one
  };

  void make_windows() {
    Windowing state;

    while (auto captured = captured_.pop()) {
      apply_plan(state);

      // Put the frame in its place in the pattern order.
      if (captured->restarts != state.restarts) {
        state.restarts = captured->restarts;
        state.windows->restart();
      }

      if (!state.windows->put(captured->frame)) ++frames_repeated_;
      captured.reset();

      resynchronisations_ = state.resynchronised_before + state.windows->resynchronisations();
      pass_on_windows(state);
    }

    // The source has ended, so incomplete windows are lost.
    if (state.windows) {
      state.windows->finish();
      windows_lost_ = state.lost_before + state.windows->lost();
    }

    windows_.close();
  }

  /// Applies changed settings. Other patterns need a new PatternWindows, whose counts start at 0;
  /// the totals go on from their present values.
  void apply_plan(Windowing& state) {
    std::shared_ptr<WindowEngine> wanted = locked(plan_);
    if (wanted == state.engine) return;

    const auto patterns_of = [](const Sequence& shown) {
      return std::tie(shown.strategy, shown.axis, shown.both_axes, shown.exposures, shown.motion);
    };
    const Sequence& sequence = wanted->setup().sequence;
    if (!state.windows || patterns_of(sequence) != patterns_of(state.engine->setup().sequence)) {
      state.lost_before = windows_lost_;
      state.resynchronised_before = resynchronisations_;
      state.windows.emplace(pattern_cycle(sequence), settings_.indexing, format_.size);
    }

    state.engine = std::move(wanted);
  }

  /// Passes on each window that the last frame completes, unless reconstruction cannot keep up.
  void pass_on_windows(Windowing& state) {
    PatternWindows& windows = *state.windows;

    while (windows.next(state.window)) {
      Pooled<LiveCloud> cloud = cloud_unless_behind(windows.first_pattern());
      if (!cloud) {
        ++windows_skipped_;
        continue;
      }

      LiveCloud& filled = cloud.fill();
      std::swap(filled.frames, state.window);
      state.window.clear();
      filled.sequence = state.engine->sequence;
      filled.first_pattern = windows.first_pattern();

      // Frames may come out of order: latency counts from the highest sequence number.
      const auto newest = std::ranges::max_element(
          filled.frames, {}, [](const auto& frame) { return frame->stamp.sequence; });
      filled.newest = (*newest)->stamp;

      window_meter_.done(filled.newest.host_time);
      windows_.push_when_room({std::move(cloud), state.engine});
    }

    windows_lost_ = state.lost_before + windows.lost();
  }

  void reconstruct() {
    while (auto window = windows_.pop()) {
      changes_->announce();  // there is room for another window
      LiveCloud& cloud = window->cloud.fill();
      WindowEngine& engine = *window->reconstruct;

      cloud.cleaned = engine.reconstruct(cloud);
      cloud_latency_.add(Clock::now() - cloud.newest.host_time);

      // Check the frames once per cycle.
      if (engine.is_due(cloud)) {
        std::vector<Finding> findings = engine.look(cloud);
        const std::lock_guard lock(mutex_);
        findings_.replace(std::move(findings), cloud.newest.sequence);
      }

      // Clouds of two cameras come from elsewhere, so the engine's fallback does not matter.
      std::string backend = engine.used->backend_for(engine.views);
      if (engine.match) backend = "matched cameras";
      if (engine.fuse) backend = "fused cameras";
      std::string failure = engine.match || engine.fuse ? "" : engine.used->fallback_reason();
      {
        const std::lock_guard lock(mutex_);
        backend_ = std::move(backend);
        fallback_reason_ = std::move(failure);
      }

      reconstruct_meter_.done(cloud.newest.host_time);
      finished_.push_when_room(std::move(window->cloud));
    }

    finished_.close();
  }

  void show() {
    while (auto cloud = finished_.pop()) {
      {
        const std::lock_guard lock(mutex_);
        // For display, see newest(): only windows in pattern order.
        if ((*cloud)->first_pattern == 0) newest_ = *cloud;
      }

      followed_.follow(*cloud);
      if (settings_.on_cloud) settings_.on_cloud(*cloud);
      // Cameras that could not be fused give no cloud.
      if (!settings_.fuse || (*cloud)->fused) show_meter_.done((*cloud)->newest.host_time);
    }
  }

  /// Stops all stages.
  void fail(std::exception_ptr failure) {
    {
      const std::lock_guard lock(mutex_);
      // The first failure is the cause; later ones only follow from it.
      if (!failure_) failure_ = std::move(failure);
    }

    stopping_ = true;
    changes_->announce();
    end_capture();
    // Closed queues wake the stages that wait for values or room.
    captured_.close();
    windows_.close();
    finished_.close();
  }

  /// Copy of a member that the mutex guards.
  template <class Value>
  [[nodiscard]] Value locked(const Value& value) const {
    const std::lock_guard lock(mutex_);
    return value;
  }

  /// A frame to fill; empty if all are in use.
  Pooled<Frame> free_frame() {
    const std::shared_ptr<Pool<Frame>> frames = locked(plan_)->frames;
    if (!paced_) return wait_for(*frames, {});

    Pooled<Frame> frame = frames->take();
    if (!frame && captured_.drop_oldest()) {
      ++frames_overwritten_;
      frame = frames->take();
    }
    return frame;
  }

  /// Waits for a cloud and for room ahead. Empty if captured frames pile up meanwhile: skipping a
  /// window costs only itself, a frame lost for lack of room costs all windows that contain it.
  /// Windows from the first pattern on, which `newest` needs, are skipped later than others.
  Pooled<LiveCloud> cloud_unless_behind(int first_pattern) const {
    const auto is_behind = [&, most = first_pattern == 0 ? 2U : 1U] {
      return paced_ && 4 * captured_.waiting() >= most * captured_.capacity();
    };

    while (paced_) {
      const std::uint64_t seen = changes_->count();
      if (stopping_ || windows_.waiting() < windows_.capacity()) break;
      if (is_behind()) return {};
      changes_->wait(seen);
    }

    return wait_for(*clouds_, cloud_patience, is_behind);
  }

  void pass_on(Pooled<Frame> frame) {
    const Clock::time_point captured_at = frame->stamp.host_time;
    // Without the source's own pace there is room, as capture() waits for it.
    if (captured_.push_over_oldest({std::move(frame), sequence_.restarts()})) ++frames_overwritten_;
    changes_->announce();  // captured frames may pile up now
    capture_meter_.done(captured_at);
  }

  /// Waits for a free value; returns an empty one `patience` after the stop, or once `gives_up`.
  template <class Value>
  Pooled<Value> wait_for(
      Pool<Value>& pool, Clock::duration patience,
      const std::function<bool()>& gives_up = [] { return false; }) const {
    std::optional<Clock::time_point> end;

    while (true) {
      const std::uint64_t seen = changes_->count();
      Pooled<Value> value = pool.take();
      if (value || gives_up() || (end && Clock::now() >= *end)) return value;

      if (stopping_ && !end) end = Clock::now() + patience;
      changes_->wait(seen, end);
    }
  }

  FrameSource& source_;
  const LiveSettings& settings_;
  const FrameFormat format_;
  const bool paced_;

  const Clock::time_point start_ = Clock::now();
  const std::shared_ptr<ChangeSignal> changes_;  ///< of all that the waiting stages look at
  std::shared_ptr<Pool<LiveCloud>> clouds_;

  mutable std::condition_variable captured_all_;  ///< see wait()
  mutable std::mutex mutex_;                      ///< guards the next seven
  FindingLog findings_;
  std::shared_ptr<WindowEngine> plan_;
  Pooled<LiveCloud> newest_;
  std::exception_ptr failure_;
  std::optional<Clock::time_point> end_;
  std::string backend_, fallback_reason_;

  BoundedQueue<Captured> captured_;
  BoundedQueue<Window> windows_;
  BoundedQueue<Pooled<LiveCloud>> finished_;

  FollowedObject followed_;

  std::atomic<bool> stopping_ = false;
  std::atomic<bool> capturing_ = true;

  SequenceWatch sequence_;  ///< used by the capture stage
  std::atomic<std::uint64_t> frames_captured_ = 0, frames_lost_ = 0, frames_overwritten_ = 0,
                             frames_repeated_ = 0, windows_lost_ = 0, windows_skipped_ = 0,
                             resynchronisations_ = 0;

  StageMeter capture_meter_, window_meter_, reconstruct_meter_, show_meter_;
  LatencyHistogram cloud_latency_, screen_latency_;

  std::vector<std::thread> threads_;
};

}  // namespace slipstream
