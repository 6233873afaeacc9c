#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "slipstream/base/image.h"

namespace slipstream {

/// What shows patterns: a projector that is a monitor, a folder of pictures, the virtual rig. The
/// counterpart of FrameSource; one thread uses it.
class PatternSink {
 public:
  virtual ~PatternSink() = default;

  /// Of the device, pixels: the size that patterns must have. None where any is taken.
  [[nodiscard]] virtual std::optional<Size> size() const = 0;
  /// Takes the patterns to be shown, grey levels of 8 bits, in place of those it had; none is shown
  /// yet. Throws Error where there are none, or they are not all of one size or not of size().
  virtual void load(std::vector<Image<std::uint8_t>> patterns) = 0;
  /// Shows pattern n, from 0, of those loaded, until the next is asked for. Returns when it is on
  /// show. Throws std::out_of_range for an n that was not loaded, WorldError where the device
  /// refuses.
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
