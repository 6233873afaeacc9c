#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "slipstream/frame_source.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {

/// Frames of a scene at one time. They are rendered together, because they share its rays.
struct Moment {
  Scene scene;
  double time = 0;                  ///< in frames, see Motion
  std::vector<std::size_t> frames;  ///< indices into ReelScript::patterns
};

/// The content of a reel before it is rendered: scenes, patterns and their order.
struct ReelScript {
  Scanner scanner;
  Photometry photometry;                ///< frame k has noise of the seed plus k
  std::vector<PatternSet> cycle{};      ///< each pattern alone, in the order shown
  std::vector<std::size_t> patterns{};  ///< of each frame: an index into `cycle`
  std::vector<Moment> moments{};        ///< in the order in which they are rendered
  std::vector<std::size_t> order{};     ///< frames in the order in which they are shown
  /// Positions in `order` where whole cycles without motion begin. They are repeated until all
  /// frames up to the end of the next such cycles, or of the reel, are rendered.
  std::vector<std::size_t> holds{};
  std::size_t hold_length = 0;  ///< frames of each of them
  std::size_t loop_from = 0;    ///< position in `order` from which the reel is repeated
  std::size_t enough = 0;       ///< see Reel::enough
};

/// Renders all frames. Throws Error as RenderedReel does.
Reel rendered(const ReelScript& script);

/// A reel whose frames are rendered by a thread of its own, first those that are shown first. Safe
/// to use from several threads.
class RenderedReel {
 public:
  using Clock = std::chrono::steady_clock;

  /// Begins to render. `progress` is called from the rendering thread with the share of frames that
  /// are rendered, above 0 to 1. Throws Error if scanner or photometry are invalid, or without
  /// frames or bits of the camera.
  explicit RenderedReel(ReelScript script, std::function<void(double)> progress = {});

  /// A reel that is there as a whole. Throws Error without frames, or if their formats differ.
  explicit RenderedReel(Reel reel);

  ~RenderedReel();  ///< ends the rendering
  RenderedReel(const RenderedReel&) = delete;
  RenderedReel& operator=(const RenderedReel&) = delete;

  [[nodiscard]] const FrameFormat& format() const { return format_; }
  [[nodiscard]] const std::vector<std::size_t>& order() const { return order_; }
  [[nodiscard]] const std::vector<std::size_t>& holds() const { return holds_; }
  [[nodiscard]] std::size_t hold_length() const { return hold_length_; }
  [[nodiscard]] std::size_t loop_from() const { return loop_from_; }
  [[nodiscard]] std::size_t enough() const { return enough_; }

  /// The frame at a position of the order; nullptr until it is rendered. Lasts as long as the reel.
  /// Throws what ended the rendering.
  [[nodiscard]] const Frame* at(std::size_t position) const;

  /// Waits for it; false if it is not rendered by then. Throws as `at`.
  bool wait_for(std::size_t position, Clock::time_point until) const;

  /// Whether all frames at positions from `first` to before `last` are rendered.
  [[nodiscard]] bool has(std::size_t first, std::size_t last) const;

 private:
  void render(const ReelScript& script, const std::function<void(double)>& progress);

  /// The caller holds the mutex.
  [[nodiscard]] bool is_rendered(std::size_t position) const;

  FrameFormat format_;
  std::vector<std::size_t> order_, holds_;
  std::size_t hold_length_ = 0, loop_from_ = 0, enough_ = 0;
  std::vector<Frame> frames_;      ///< each is written once, before it counts as rendered
  std::vector<bool> is_rendered_;  ///< guarded by the mutex, as all that follows
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::exception_ptr failure_;
  std::atomic<bool> ending_ = false;
  std::thread thread_;  ///< uses the members above
};

/// Steps through a reel: where its next part is not rendered yet, the scene rests for whole cycles.
/// For one thread.
class ReelPlayer {
 public:
  explicit ReelPlayer(std::shared_ptr<const RenderedReel> reel) : reel_(std::move(reel)) {}

  [[nodiscard]] const RenderedReel& reel() const { return *reel_; }

  void restart() {
    position_ = 0;
    has_passed_enough_ = false;
  }

  /// The frame to show; nullptr until it is rendered.
  [[nodiscard]] const Frame* frame() const { return reel_->at(position_); }
  bool wait_for_frame(RenderedReel::Clock::time_point until) const {
    return reel_->wait_for(position_, until);
  }

  void advance(std::size_t frames = 1);

  /// Whether the last frame that a client needs has been shown or passed, see Reel::enough.
  [[nodiscard]] bool has_shown_enough() const { return has_passed_enough_ || is_last_needed(); }

 private:
  [[nodiscard]] bool is_last_needed() const;

  std::shared_ptr<const RenderedReel> reel_;
  std::size_t position_ = 0;
  bool has_passed_enough_ = false;
};

}  // namespace slipstream
