#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "slipstream/base/image.h"

namespace slipstream {

/// Size and depth of a camera's pictures: 8 bits, or 9 to 16 in 16-bit pixels.
struct FrameFormat {
  Size size;
  int bits = 8;

  friend bool operator==(const FrameFormat&, const FrameFormat&) = default;
};

/// Of its pixels.
std::uint64_t byte_count(const FrameFormat& format);

/// Throws Error unless the size is positive and the bits are 8 to 16.
void require_valid(const FrameFormat& format);

/// Where and when a frame was taken.
struct FrameStamp {
  /// The device's count of frames, from 0 at the start; a gap is a lost frame.
  std::uint64_t sequence = 0;
  /// Which pattern it shows, where the source itself knows; none where it must be counted.
  std::optional<int> pattern_index;
  std::chrono::nanoseconds device_time{};           ///< of the device's own clock
  std::chrono::steady_clock::time_point host_time;  ///< when the frame was whole in this machine
};

/// One camera picture. Its memory is allocated once and filled again and again.
struct Frame {
  Frame() = default;
  /// Black. Throws Error where the format is not valid.
  explicit Frame(const FrameFormat& format);

  [[nodiscard]] FrameFormat format() const {
    return {std::visit([](const auto& image) { return image.size(); }, pixels), bits};
  }

  std::variant<Image<std::uint8_t>, Image<std::uint16_t>> pixels;
  int bits = 8;
  FrameStamp stamp;
};

/// What a camera may let be set while it gives frames.
enum class CameraControl {
  exposure,    ///< of each frame, ms
  gain,        ///< in the camera's unit, mostly dB
  frame_rate,  ///< Hz, of a camera that runs freely
};

inline constexpr std::array camera_controls{CameraControl::exposure, CameraControl::gain,
                                            CameraControl::frame_rate};

/// What one of them is set to, and between what it can be.
struct ControlValue {
  double value = 0;
  double least = 0;
  double most = 0;
};

/// Of a source that is a camera. From any thread, and while frames come.
class CameraControls {
 public:
  virtual ~CameraControls() = default;
  /// As the camera says it; none where it has no such setting, or is gone.
  [[nodiscard]] virtual std::optional<ControlValue> control(CameraControl which) const = 0;
  /// Frames taken from about now on are taken so; a camera that was gone is set so again. Throws
  /// Error where the camera refuses.
  virtual void set_control(CameraControl which, double value) = 0;
};

/// What came of waiting for a frame.
enum class Arrival {
  frame,    ///< one came
  nothing,  ///< none in time, or the device is gone and being sought (FrameSource::state tells)
  damaged,  ///< one came that was not whole or of another size: it is lost
  ended,    ///< there are no more: the end of a recording
};

/// What a source counts from its start.
struct SourceCounters {
  std::uint64_t delivered = 0;   ///< frames given out
  std::uint64_t lost = 0;        ///< frames that the device took and that did not arrive whole
  std::uint64_t resent = 0;      ///< packets that had to be asked for again
  std::uint64_t reconnects = 0;  ///< times that the device was gone and came back
};

/// Where frames come from. One thread uses it; `state` and `counters` may be asked from any.
class FrameSource {
 public:
  virtual ~FrameSource() = default;

  /// Of every frame that it gives.
  [[nodiscard]] virtual FrameFormat format() const = 0;
  /// Whether frames come at a pace of the source's own, whether or not somebody takes them; without
  /// one (a recording read as fast as it goes) the next frame waits until it is asked for.
  [[nodiscard]] virtual bool has_own_pace() const = 0;
  /// Frames come from here on. Throws where the device refuses.
  virtual void start() = 0;
  /// Waits for the next frame, `timeout` at most, and copies it into `frame`, which is of format().
  /// A device that is gone is sought again meanwhile; nothing is thrown for it.
  virtual Arrival next(Frame& frame, std::chrono::milliseconds timeout) = 0;
  virtual void stop() = 0;
  /// Asks for a frame, of a camera that waits for that; does nothing with another.
  virtual void trigger() {}
  [[nodiscard]] virtual SourceCounters counters() const = 0;
  /// One line for people where something is amiss ("camera X is gone; looking for it"), else empty.
  [[nodiscard]] virtual std::string state() const = 0;
  /// What can be set while frames come; null where nothing can. As long as the source.
  virtual CameraControls* controls() { return nullptr; }
};

/// A source of what another gives, which answers all else.
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

/// Frames that a camera gives over and over, each as often as `order` names it.
struct Reel {
  std::vector<Frame> frames;
  std::vector<std::size_t> order;  ///< which of the frames comes when
  std::size_t enough = 0;  ///< frames by which all of it was seen; 0: as many as in the order
};

/// Each frame once, one after the other.
Reel reel_of(std::vector<Frame> frames);

/// What shows patterns: a monitor, a folder of pictures, the virtual rig. One thread uses it.
class PatternSink {
 public:
  virtual ~PatternSink() = default;

  /// Of the device, pixels: the size that patterns must have. None where any is taken.
  [[nodiscard]] virtual std::optional<Size> size() const = 0;
  /// Takes the patterns to be shown, grey levels of 8 bits, in place of those it had; none is shown
  /// yet. Throws Error where there are none, or they are not all of one size or not of size().
  virtual void load(std::vector<Image<std::uint8_t>> patterns) = 0;
  /// Shows pattern n of those loaded until the next; returns once it is on show. Throws
  /// std::out_of_range for an n that was not loaded, WorldError if the device refuses.
  virtual void show(std::size_t n) = 0;
  /// How many times a pattern was put on show since the sink was opened.
  [[nodiscard]] virtual std::uint64_t shown() const = 0;
  /// One line for people where something is amiss ("the monitor has no gamma table"), else empty.
  [[nodiscard]] virtual std::string state() const = 0;
};

/// What every sink refuses. Throws Error where there are no patterns, or one is not of `size`, or
/// of the first one's where that is none; `device` is what the message calls the sink.
template <class Pixel = std::uint8_t>
void require_patterns(const std::vector<Image<Pixel>>& patterns, std::optional<Size> size,
                      const std::string& device);

}  // namespace slipstream
