#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>
#include <vector>

#include "slipstream/frames/pattern_windows.h"
#include "slipstream/live/bounded_queue.h"
#include "slipstream/live/live_pipeline.h"
#include "slipstream/live/meters.h"
#include "slipstream/live/object_track.h"
#include "slipstream/reconstruct/engine.h"

namespace slipstream {

/// What a window's frames are checked and reconstructed by, and their views, in memory that is kept
/// from one to the next.
struct WindowEngine {
  WindowEngine(const EngineSetup& setup, const LiveSettings& settings);

  /// Into the window's cloud, and how much of the window that took; without a scanner it is empty.
  /// What cleaning took, by reason.
  ValidityCounts reconstruct(LiveCloud& window);
  /// Whether the window is to be looked at: once in a cycle, when its last pattern has come.
  [[nodiscard]] bool is_due(const LiveCloud& window) const;
  std::vector<Finding> look(const LiveCloud& window);

  /// Of windows that begin with each pattern; one for all where they are in pattern order.
  std::vector<Engine> engines;
  std::optional<Engine> still;  ///< of one cycle, where that is to do while nothing moves
  Engine* used = nullptr;       ///< that of them which made the newest cloud
  FrameViews views;
  std::function<std::vector<Finding>(const FrameViews&)> check;
  std::optional<std::uint64_t> looked;  ///< sequence of the newest frame that was looked at
};

/// By what windows are made and reconstructed from now on, and the memory that takes.
struct LivePlan {
  std::shared_ptr<WindowEngine> reconstruct;
  std::shared_ptr<Pool<Frame>> frames;
};

/// Places that the queues before reconstruct and show have. One keeps the stages apart; more would
/// only make clouds older.
inline constexpr std::size_t stage_places = 1;

/// The threads of a LivePipeline from start to stop, and what passes between them.
class LiveRun {
 public:
  /// The source has been started. All must live longer than this.
  LiveRun(FrameSource& source, const LiveSettings& settings,
          std::shared_ptr<Pool<LiveCloud>> clouds, std::shared_ptr<const LivePlan> plan);
  ~LiveRun() { stop(); }
  LiveRun(const LiveRun&) = delete;
  LiveRun& operator=(const LiveRun&) = delete;

  void stop();
  [[nodiscard]] bool capturing() const { return capturing_; }
  void change(std::shared_ptr<const LivePlan> plan);
  void shown(std::chrono::steady_clock::time_point captured);
  [[nodiscard]] std::exception_ptr failure() const { return locked(failure_); }
  [[nodiscard]] Pooled<LiveCloud> newest() const { return locked(newest_); }
  [[nodiscard]] LiveStatistics statistics() const;
  [[nodiscard]] std::vector<LiveFinding> findings() const { return locked(findings_).told(); }
  [[nodiscard]] std::string gpu_failure() const { return locked(gpu_failure_); }
  [[nodiscard]] ModelPoints model() const { return followed_.model(); }

 private:
  using Clock = std::chrono::steady_clock;
  struct Captured {
    Pooled<Frame> frame;
    /// Of the source, up to this frame: the frame at which it began to count again may be dropped.
    std::uint64_t restarts = 0;
  };
  struct Window {
    Pooled<LiveCloud> cloud;  ///< but for its points
    std::shared_ptr<WindowEngine> reconstruct;
  };

  void capture();
  void make_windows();
  void reconstruct();
  void show();

  /// Runs a stage; what it throws ends the whole run.
  template <class Stage>
  std::thread thread_of(Stage stage);
  void fail(std::exception_ptr failure);

  /// A copy of one of the members that the mutex guards.
  template <class Value>
  [[nodiscard]] Value locked(const Value& value) const {
    const std::lock_guard lock(mutex_);
    return value;
  }
  /// A frame to be filled; empty where there is none.
  Pooled<Frame> free_frame();
  /// Counts a frame that has come, and passes it on unless it came before.
  void receive(Pooled<Frame> frame);
  /// Waits for a cloud that nobody holds; empty once that is waited for in vain at the stop.
  Pooled<LiveCloud> free_cloud();

  FrameSource& source_;
  const LiveSettings& settings_;
  const FrameFormat format_;
  const bool paced_;
  const Clock::time_point start_ = Clock::now();
  std::shared_ptr<Pool<LiveCloud>> clouds_;

  mutable std::mutex mutex_;  ///< of the seven that follow
  FindingLog findings_;
  std::shared_ptr<const LivePlan> plan_;
  Pooled<LiveCloud> newest_;
  std::exception_ptr failure_;
  std::optional<Clock::time_point> end_;
  std::string backend_, gpu_failure_;

  BoundedQueue<Captured> captured_;
  BoundedQueue<Window> windows_;
  BoundedQueue<Pooled<LiveCloud>> finished_;

  FollowedObject followed_;

  std::atomic<bool> stopping_ = false;
  std::atomic<bool> capturing_ = true;
  SequenceWatch sequence_;  ///< of the capture stage
  std::atomic<std::uint64_t> frames_captured_ = 0, frames_lost_ = 0, frames_overwritten_ = 0,
                             frames_repeated_ = 0, windows_lost_ = 0, resynchronisations_ = 0;
  StageMeter capture_meter_, window_meter_, reconstruct_meter_, show_meter_;
  LatencyHistogram cloud_latency_, screen_latency_;
  std::array<std::thread, 4> threads_;
};

}  // namespace slipstream
