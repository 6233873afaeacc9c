#pragma once

#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "slipstream/frame_source.h"
#include "slipstream/live_pipeline.h"

namespace slipstream {

/// One result of ScriptedSource::next().
struct ScriptedStep {
  Arrival arrival = Arrival::frame;
  int frame = 0;  ///< index into the source's pictures, modulo their number
  std::uint64_t sequence = 0;
  std::optional<int> pattern_index = {};
  std::string state = {};  ///< source state from this step on
};

/// Frames in sequence.
inline std::vector<ScriptedStep> in_a_row(int count) {
  std::vector<ScriptedStep> script;
  for (int n = 0; n < count; ++n) {
    script.push_back({.frame = n, .sequence = static_cast<std::uint64_t>(n)});
  }
  return script;
}

/// A source that delivers frames from a script, then ends.
class ScriptedSource : public FrameSource {
 public:
  ScriptedSource(std::vector<Frame> pictures, std::vector<ScriptedStep> script, bool paced = false)
      : pictures_(std::move(pictures)), script_(std::move(script)), paced_(paced) {}

  /// Called before each step, with its number.
  std::function<void(std::size_t)> before_step = [](std::size_t) {};

  [[nodiscard]] FrameFormat format() const override { return pictures_.front().format(); }
  [[nodiscard]] bool has_own_pace() const override { return paced_; }
  void start() override { step_ = 0; }
  void stop() override {}
  [[nodiscard]] SourceCounters counters() const override { return {}; }
  [[nodiscard]] std::string state() const override {
    const std::lock_guard lock(mutex_);
    return state_;
  }

  Arrival next(Frame& frame, std::chrono::milliseconds) override {
    if (step_ == script_.size()) return Arrival::ended;
    before_step(step_);
    const ScriptedStep& step = script_[step_++];
    {
      const std::lock_guard lock(mutex_);
      state_ = step.state;
    }
    if (step.arrival != Arrival::frame) return step.arrival;
    frame = pictures_[static_cast<std::size_t>(step.frame) % pictures_.size()];
    frame.stamp = {.sequence = step.sequence,
                   .pattern_index = step.pattern_index,
                   .host_time = std::chrono::steady_clock::now()};
    return Arrival::frame;
  }

 private:
  std::vector<Frame> pictures_;
  std::vector<ScriptedStep> script_;
  bool paced_;
  std::size_t step_ = 0;
  mutable std::mutex mutex_;
  std::string state_;
};

inline void wait_for_end(LivePipeline& pipeline) {
  pipeline.wait();
  pipeline.stop();
}

inline void run_to_its_end(LivePipeline& pipeline) {
  pipeline.start();
  wait_for_end(pipeline);
}

}  // namespace slipstream
