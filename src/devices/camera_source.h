#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include <fmt/format.h>

#include "slipstream/camera.h"
#include "slipstream/error.h"

namespace slipstream {

/// Counts a camera's frames from 0 by the camera's own numbers, and counts missing ones. The
/// camera's numbers may wrap around: GigE Vision counts from 1 to 65535, then from 1 again (0 is
/// never used). Numbers above 65535 are assumed never to wrap.
class FrameCount {
 public:
  /// `cycle`: patterns per scan, at least 1. Frame k of a camera started at the first pattern shows
  /// pattern k modulo `cycle`. When a lost camera starts again at the first pattern, the count
  /// continues at the next multiple of `cycle` that leaves at least one frame missing: the pattern
  /// stays right, and no scan mixes frames from before and after.
  explicit FrameCount(int cycle) : cycle_(static_cast<std::uint64_t>(cycle)) {}

  /// The camera starts or restarts: its frame numbered `first` shows the first pattern.
  void begin(std::uint64_t first) {
    if (!none_yet_) start_ = (expected_ + cycle_) / cycle_ * cycle_;
    none_yet_ = true;
    first_ = last_ = first;
    unwrapped_ = 0;
  }

  /// The count of the frame with this camera number. A number more than `far` below the last, or
  /// below `first`, means that the camera restarted; begin() is then called here.
  std::uint64_t operator()(std::uint64_t number) {
    // 1. A large step back: the camera restarted.
    if (step_to(number) < -far || unwrapped_ + step_to(number) < 0) {
      begin(number >= first_ && number < first_ + far ? first_ : number);
    }

    // 2. Count on across the wrap of its 16-bit numbers.
    unwrapped_ += step_to(number);
    last_ = number;

    // 3. Frames skipped are missing, but not those before the first.
    const std::uint64_t count = start_ + static_cast<std::uint64_t>(unwrapped_);
    if (none_yet_) expected_ = count;
    none_yet_ = false;
    if (count >= expected_) {
      missing_ += count - expected_;
      expected_ = count + 1;
    }

    return count;
  }

  /// Frames lost after the first one; earlier ones fall into the connection setup.
  [[nodiscard]] std::uint64_t missing() const { return missing_; }

  /// A larger step back means a restarted camera, not a late frame.
  static constexpr int far = 1000;

 private:
  /// Step from the last number to this one, across the 16-bit wrap if that is shorter.
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
  bool none_yet_ = true;        ///< no frame since begin()
  std::uint64_t first_ = 0;     ///< the camera's number of the first frame after begin()
  std::uint64_t last_ = 0;      ///< the camera's number of the last frame received
  std::int64_t unwrapped_ = 0;  ///< frames from `first_` to `last_`
};

/// Base of a camera that may disconnect and return: its connection (null while lost), its settings
/// for this and later connections, and counters. `Connection` is like CameraControls.
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
    // Remembered for the next connection. Exposures are ms here, s in the settings.
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
  /// Throws Error if the settings have no pattern.
  CameraSource(std::string name, CameraSettings settings, std::shared_ptr<Connection> connection,
               FrameFormat format)
      : name_(std::move(name)),
        settings_(std::move(settings)),
        connection_(std::move(connection)),
        format_(format),
        count_(settings_.cycle) {
    settings_.node_set = {};  // the caller may be gone when the camera is opened again
    if (settings_.cycle < 1) {
      throw Error(fmt::format("{} patterns per scan; expected at least 1", settings_.cycle));
    }
  }

  /// For threads other than that of next(), which reads connection_.
  [[nodiscard]] std::shared_ptr<Connection> shared_connection() const {
    const std::lock_guard lock(mutex_);
    return connection_;
  }

  [[nodiscard]] CameraSettings settings_now() const {
    const std::lock_guard lock(mutex_);
    return settings_;
  }

  /// Marks the camera as lost and returns its connection.
  std::shared_ptr<Connection> lose() {
    still_lose("");
    const std::lock_guard lock(mutex_);
    return std::exchange(connection_, nullptr);
  }

  /// Sets the state of a lost camera, and why it refuses to be opened if it answers.
  void still_lose(const std::string& why) {
    const std::lock_guard lock(mutex_);
    state_ = fmt::format("camera {} is lost; searching for it{}{}",
                         name_.empty() ? "(the first found)" : name_, why.empty() ? "" : "; ", why);
  }

  void regain(std::shared_ptr<Connection> found) {
    const std::lock_guard lock(mutex_);
    connection_ = std::move(found);
    state_.clear();
    ++reconnects_;
  }

  /// The index of a received frame, from the camera's own number.
  std::uint64_t count(std::uint64_t number) {
    const std::uint64_t sequence = count_(number);
    lost_ = count_.missing();
    ++delivered_;
    return sequence;
  }

  const std::string name_;
  CameraSettings settings_;  ///< only exposure, gain and rate may change while streaming
  std::shared_ptr<Connection> connection_;
  const FrameFormat format_;
  FrameCount count_;

 private:
  mutable std::mutex mutex_;  ///< guards connection_, settings_ and state_ against other threads
  std::string state_;
  std::atomic<std::uint64_t> delivered_ = 0, lost_ = 0, reconnects_ = 0;
};

}  // namespace slipstream
