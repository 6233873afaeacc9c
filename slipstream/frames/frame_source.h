#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "slipstream/frames/camera_controls.h"
#include "slipstream/frames/frame.h"

namespace slipstream {

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

/// Where frames come from: a camera, a recording, the virtual scanner. One thread uses it; `state`
/// and `counters` may be asked from any.
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

}  // namespace slipstream
