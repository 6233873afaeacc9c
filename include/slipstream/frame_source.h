#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "slipstream/image.h"

namespace slipstream {

/// A share of a value in a Pool; the value returns to the pool with its last share. Shares may be
/// copied and dropped in any thread, and keep the pool's memory alive.
template <class Value>
class Pooled {
 public:
  Pooled() = default;

  Pooled(const Pooled& other) : slots_(other.slots_), slot_(other.slot_) {
    if (slot_) slot_->shares.fetch_add(1, std::memory_order_relaxed);
  }

  Pooled(Pooled&& other) noexcept
      : slots_(std::move(other.slots_)), slot_(std::exchange(other.slot_, nullptr)) {}

  Pooled& operator=(Pooled other) noexcept {
    std::swap(slots_, other.slots_);
    std::swap(slot_, other.slot_);
    return *this;
  }

  ~Pooled() {
    if (!slot_) return;
    const bool is_last = slot_->shares.fetch_sub(1, std::memory_order_release) == 1;
    if (is_last && slots_->returned) slots_->returned();
  }

  explicit operator bool() const { return slot_ != nullptr; }
  const Value& operator*() const { return slot_->value; }
  const Value* operator->() const { return &slot_->value; }
  /// Writable access; only for the thread that took it, before the share is first copied.
  [[nodiscard]] Value& fill() { return slot_->value; }

 private:
  template <class>
  friend class Pool;

  struct Slot {
    std::atomic<int> shares = 0;
    Value value;
  };
  struct Slots {
    std::vector<Slot> all;
    std::function<void()> returned;
  };

  Pooled(std::shared_ptr<Slots> slots, Slot& slot) : slots_(std::move(slots)), slot_(&slot) {}

  std::shared_ptr<Slots> slots_;
  Slot* slot_ = nullptr;
};

/// Values that are allocated once and reused.
template <class Value>
class Pool {
 public:
  /// `count` values, each made by `make()`. `returned`, if not empty, is called whenever a value
  /// has become unused, in the thread that dropped its last share; it must not throw.
  template <class Make>
  Pool(std::size_t count, Make make, std::function<void()> returned = {})
      : slots_(std::make_shared<typename Pooled<Value>::Slots>()) {
    slots_->all = std::vector<typename Pooled<Value>::Slot>(count);
    slots_->returned = std::move(returned);
    for (auto& slot : slots_->all) slot.value = make();
  }

  /// An unused value, as its last owner left it; empty share if all are in use. Call it from one
  /// thread.
  [[nodiscard]] Pooled<Value> take() {
    std::vector<typename Pooled<Value>::Slot>& all = slots_->all;
    for (std::size_t tried = 0; tried < all.size(); ++tried) {
      // Round robin; acquire makes the last owner's writes visible.
      next_ = (next_ + 1) % all.size();
      auto& slot = all[next_];
      int unused = 0;
      if (slot.shares.compare_exchange_strong(unused, 1, std::memory_order_acquire)) {
        return {slots_, slot};
      }
    }

    return {};
  }

 private:
  std::shared_ptr<typename Pooled<Value>::Slots> slots_;
  std::size_t next_ = 0;
};

/// Size and bit depth of a camera's images: 8 bits, or 9 to 16 in 16-bit pixels.
struct FrameFormat {
  Size size;
  int bits = 8;

  friend bool operator==(const FrameFormat&, const FrameFormat&) = default;
};

/// Bytes of the pixels of one frame.
std::uint64_t byte_count(const FrameFormat& format);

/// Throws Error unless the size is positive and the bits are 8 to 16.
void require_valid(const FrameFormat& format);

/// Position and time of a frame in the stream.
struct FrameStamp {
  /// The device's frame counter, from 0 at the start; a gap means lost frames.
  std::uint64_t sequence = 0;
  /// Index of the displayed pattern, if the source knows it; otherwise frames are counted.
  std::optional<int> pattern_index;
  std::chrono::nanoseconds device_time{};           ///< from the device's clock
  std::chrono::steady_clock::time_point host_time;  ///< when the frame was fully received
};

/// One camera image. Allocated once and refilled.
struct Frame {
  Frame() = default;
  /// A black frame. Throws Error if the format is invalid.
  explicit Frame(const FrameFormat& format);

  [[nodiscard]] FrameFormat format() const {
    return {std::visit([](const auto& image) { return image.size(); }, pixels), bits};
  }

  std::variant<Image<std::uint8_t>, Image<std::uint16_t>> pixels;
  int bits = 8;
  FrameStamp stamp;
  /// Picture of the same pattern by a second camera, with the same bits; no pixels without one: see
  /// PairedSource.
  std::variant<Image<std::uint8_t>, Image<std::uint16_t>> second;
};

/// Camera settings that can change while streaming.
enum class CameraControl {
  exposure,    ///< of each frame, ms
  gain,        ///< in the camera's unit, usually dB
  frame_rate,  ///< Hz, for a free-running camera
};

/// A control's name and texts in panel, page and live changes.
struct CameraControlWords {
  CameraControl which;
  const char *name, *help, *unit, *shown_as;
};
inline constexpr std::array<CameraControlWords, 3> camera_controls{
    {{CameraControl::exposure, "exposure", "exposure time per frame", "ms", "%.3f ms"},
     {CameraControl::gain, "gain", "camera gain, usually dB", "", "%.1f"},
     {CameraControl::frame_rate, "rate", "frame rate of a free-running camera", "per s",
      "%.1f per s"}}};

struct ControlValue {
  double value = 0, least = 0, most = 0;
};

/// Temperatures of a camera, degrees Celsius, by the part that it names, e.g. "Sensor".
using Temperatures = std::map<std::string, double>;

/// Controls of a camera source. Thread-safe, also while streaming.
class CameraControls {
 public:
  virtual ~CameraControls() = default;
  /// As reported by the camera; nullopt if unsupported or disconnected.
  [[nodiscard]] virtual std::optional<ControlValue> control(CameraControl which) const = 0;
  /// Applies to frames from about now on, and again after a reconnection. Throws Error if the
  /// camera refuses.
  virtual void set_control(CameraControl which, double value) = 0;
  /// As measured by the camera now; empty if unsupported or disconnected.
  [[nodiscard]] virtual Temperatures temperatures() const { return {}; }
};

/// Result of waiting for a frame.
enum class Arrival {
  frame,    ///< a frame was received
  nothing,  ///< timeout, or the device is disconnected and reconnecting (see FrameSource::state)
  damaged,  ///< an incomplete frame or one of another size: it is lost
  ended,    ///< end of a recording
};

/// Counters of a source since its start.
struct SourceCounters {
  std::uint64_t delivered = 0;   ///< frames returned
  std::uint64_t lost = 0;        ///< frames taken but not fully received
  std::uint64_t resent = 0;      ///< packets requested again
  std::uint64_t reconnects = 0;  ///< disconnections followed by a reconnection
};

/// A source of frames. Use it from one thread; `state` and `counters` are thread-safe.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// The format of every frame.
  [[nodiscard]] virtual FrameFormat format() const = 0;
  /// Whether frames arrive at the source's own pace, whether or not they are read; otherwise (a
  /// recording read at full speed) the next frame waits until it is read.
  [[nodiscard]] virtual bool has_own_pace() const = 0;
  /// Starts streaming. Throws if the device refuses.
  virtual void start() = 0;
  /// Waits up to `timeout` for the next frame and copies it into `frame`, which must have format().
  /// Reconnects to a disconnected device meanwhile, without throwing.
  virtual Arrival next(Frame& frame, std::chrono::milliseconds timeout) = 0;
  virtual void stop() = 0;
  /// Triggers a frame on a camera in software-trigger mode; otherwise does nothing.
  virtual void trigger() {}
  [[nodiscard]] virtual SourceCounters counters() const = 0;
  /// One line for the user about a problem ("camera X is gone; looking for it"), otherwise empty.
  [[nodiscard]] virtual std::string state() const = 0;
  /// Settings that can change while streaming; null if unsupported. Valid as long as the source.
  virtual CameraControls* controls() { return nullptr; }
};

/// The temperatures of the source's camera; empty if it has no controls.
Temperatures temperatures_of(FrameSource& source);

/// A source that wraps another and forwards all other calls to it.
class SourceOver : public FrameSource {
 public:
  explicit SourceOver(std::unique_ptr<FrameSource> source) : source_(std::move(source)) {}

  [[nodiscard]] bool has_own_pace() const override { return source_->has_own_pace(); }
  void stop() override { source_->stop(); }
  void trigger() override { source_->trigger(); }
  [[nodiscard]] SourceCounters counters() const override { return source_->counters(); }
  [[nodiscard]] std::string state() const override { return source_->state(); }
  CameraControls* controls() override { return source_->controls(); }

 protected:
  std::unique_ptr<FrameSource> source_;
};

/// A repeated sequence of camera frames, in the given order.
struct Reel {
  std::vector<Frame> frames;
  std::vector<std::size_t> order;  ///< indices into `frames`
  std::size_t enough = 0;          ///< frames after which all was seen; 0: the length of `order`
};

/// Each frame once, in sequence.
Reel reel_of(std::vector<Frame> frames);

/// A display for patterns: a monitor, or a controller of a projector. Use it from one thread.
class PatternSink {
 public:
  virtual ~PatternSink() = default;

  /// The required pattern size, pixels; nullopt if any size is accepted.
  [[nodiscard]] virtual std::optional<Size> size() const = 0;
  /// Replaces the patterns, in 8-bit grey levels, without showing any. Throws Error if there are
  /// none, or their sizes differ from each other or from size().
  virtual void load(std::vector<Image<std::uint8_t>> patterns) = 0;
  /// Shows loaded pattern n until the next call; returns once it is displayed. Throws
  /// std::out_of_range if n is not loaded, WorldError if the device refuses.
  virtual void show(std::size_t n) = 0;
  /// Number of times a pattern was displayed since the sink was opened.
  [[nodiscard]] virtual std::uint64_t shown() const = 0;
  /// One line for the user about a problem ("the monitor has no gamma table"), otherwise empty.
  [[nodiscard]] virtual std::string state() const = 0;
};

/// Checks common to all sinks: throws Error if there are no patterns, or one differs from `size`
/// or, if nullopt, from the first one's. `device` is the sink's name in the message.
template <class Pixel = std::uint8_t>
void require_patterns(const std::vector<Image<Pixel>>& patterns, std::optional<Size> size,
                      const std::string& device);

/// How a frame's pattern index is known. In each case images are monitored and a slipped index is
/// corrected: see LivePipeline.
enum class PatternIndexing {
  source,   ///< FrameStamp::pattern_index; frames without it are counted on
  counted,  ///< sequence number modulo patterns: the projector triggers the camera
  marker,   ///< a dark or bright frame before the first pattern of each cycle of N + 1 frames
};

/// "source" (or "told", as before 0.3), "counted", "marker"; throws Error for any other name.
PatternIndexing pattern_indexing_named(std::string_view name);

}  // namespace slipstream
