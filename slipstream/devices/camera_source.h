#pragma once

#include <atomic>
#include <mutex>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/devices/camera.h"

namespace slipstream {

/// Counts a camera's frames from 0 by the camera's own numbers, and how many are missing. Those may
/// begin again: GigE Vision counts 1 to 65535 and then from 1 (no frame is numbered 0). A camera
/// with numbers above 65535 is taken never to run out of them.
class FrameCount {
 public:
  /// `cycle`: patterns in a scan, at least 1. Frame k of a camera that was started at the first
  /// pattern shows pattern k modulo `cycle`. When the camera was gone and starts again at the first
  /// pattern, the count goes on at the next multiple of `cycle` that leaves at least one frame
  /// missing: the pattern stays right, and no scan mixes frames from before and after.
  explicit FrameCount(int cycle) : cycle_(static_cast<std::uint64_t>(cycle)) {}

  /// The camera starts, or starts again: its frame numbered `first` shows the first pattern.
  void begin(std::uint64_t first) {
    if (!none_yet_) start_ = (expected_ + cycle_) / cycle_ * cycle_;
    none_yet_ = true;
    first_ = last_ = first;
    unwrapped_ = 0;
  }

  /// The count of the frame that the camera gave this number. A number more than `far` below the
  /// last, or below `first`, says that the camera has started again; begin() is then called here.
  std::uint64_t operator()(std::uint64_t number) {
    if (step_to(number) < -far || unwrapped_ + step_to(number) < 0) {
      begin(number >= first_ && number < first_ + far ? first_ : number);
    }
    unwrapped_ += step_to(number);
    last_ = number;
    const std::uint64_t count = start_ + static_cast<std::uint64_t>(unwrapped_);
    if (none_yet_) expected_ = count;
    none_yet_ = false;
    if (count >= expected_) {
      missing_ += count - expected_;
      expected_ = count + 1;
    }
    return count;
  }

  /// Frames that never came after the first: before it the connection is still being set up.
  [[nodiscard]] std::uint64_t missing() const { return missing_; }
  /// A step back of more numbers than this is a camera that started again, not a late frame.
  static constexpr int far = 1000;

 private:
  /// From the last number to this one, across the end of 16 bits where that is nearer.
  [[nodiscard]] std::int64_t step_to(std::uint64_t number) const {
    constexpr std::int64_t round = 65535;
    const auto step = static_cast<std::int64_t>(number - last_);
    if (number > round || last_ > round) return step;
    if (step < -round / 2) return step + round;
    return step > round / 2 && unwrapped_ > round / 2 ? step - round : step;
  }

  std::uint64_t cycle_;
  std::uint64_t start_ = 0;     ///< the count of the frame numbered `first_`
  std::uint64_t expected_ = 0;  ///< the count after the largest so far
  std::uint64_t missing_ = 0;
  bool none_yet_ = true;        ///< no frame came since begin()
  std::uint64_t first_ = 0;     ///< the camera's number of the first frame after begin()
  std::uint64_t last_ = 0;      ///< the camera's number of the last frame that came
  std::int64_t unwrapped_ = 0;  ///< frames from `first_` to `last_`
};

/// Base of a camera that may go away and come back: its connection, null while it is gone, its
/// settings, also for the next connection, and counters. `Connection` is like CameraControls.
template <class Connection>
class CameraSource : public FrameSource, public CameraControls {
 public:
  [[nodiscard]] FrameFormat format() const final { return format_; }
  [[nodiscard]] bool has_own_pace() const final { return true; }
  CameraControls* controls() final { return this; }

  [[nodiscard]] std::optional<ControlValue> control(CameraControl which) const override {
    const std::shared_ptr<Connection> connection = shared_connection();
    return connection ? connection->control(which) : std::nullopt;
  }
  void set_control(CameraControl which, double value) final {
    if (const auto connection = shared_connection()) connection->set_control(which, value);
    const std::lock_guard lock(mutex_);
    auto& setting = which == CameraControl::exposure ? settings_.exposure
                    : which == CameraControl::gain   ? settings_.gain
                                                     : settings_.frame_rate;
    setting = which == CameraControl::exposure ? value / 1e3 : value;
  }

  [[nodiscard]] SourceCounters counters() const override {
    return {.delivered = delivered_, .lost = lost_, .resent = 0, .reconnects = reconnects_};
  }
  [[nodiscard]] std::string state() const final {
    const std::lock_guard lock(mutex_);
    return state_;
  }

 protected:
  /// Throws Error where the settings have no pattern.
  CameraSource(std::string name, CameraSettings settings, std::shared_ptr<Connection> connection,
               FrameFormat format)
      : name_(std::move(name)),
        settings_(std::move(settings)),
        connection_(std::move(connection)),
        format_(format),
        count_(settings_.cycle) {
    if (settings_.cycle < 1) {
      throw Error(fmt::format("{} patterns in a scan; at least 1", settings_.cycle));
    }
  }

  /// For other threads than that of next(), which reads connection_.
  [[nodiscard]] std::shared_ptr<Connection> shared_connection() const {
    const std::lock_guard lock(mutex_);
    return connection_;
  }
  [[nodiscard]] CameraSettings settings_now() const {
    const std::lock_guard lock(mutex_);
    return settings_;
  }
  /// The camera is gone; returns what connected to it.
  std::shared_ptr<Connection> lose() {
    const std::lock_guard lock(mutex_);
    state_ = fmt::format("camera {} is gone; looking for it",
                         name_.empty() ? "(the first found)" : name_);
    return std::exchange(connection_, nullptr);
  }
  void regain(std::shared_ptr<Connection> found) {
    const std::lock_guard lock(mutex_);
    connection_ = std::move(found);
    state_.clear();
    ++reconnects_;
  }
  /// The place of a frame that came, by the camera's own number.
  std::uint64_t count(std::uint64_t number) {
    const std::uint64_t sequence = count_(number);
    lost_ = count_.missing();
    ++delivered_;
    return sequence;
  }

  const std::string name_;
  CameraSettings
      settings_;  ///< exposure, gain and rate change while frames come, the rest does not
  std::shared_ptr<Connection> connection_;
  const FrameFormat format_;
  FrameCount count_;

 private:
  mutable std::mutex mutex_;  ///< of connection_ and settings_ against other threads, and of state_
  std::string state_;
  std::atomic<std::uint64_t> delivered_ = 0, lost_ = 0, reconnects_ = 0;
};

}  // namespace slipstream
