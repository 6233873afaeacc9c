#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <string>

#include "slipstream/frame_source.h"

namespace slipstream {

/// Two cameras that see the same patterns, as one source: each frame has the picture of the second
/// in Frame::second. Frames belong together if their sequence numbers are equal, so both cameras
/// are triggered by the projector and started before it. A frame that one camera has lost is lost
/// in both. Two frames with equal numbers and different pattern indices count as damaged: pictures
/// of different patterns are never combined.
class PairedSource : public SourceOver {
 public:
  /// Throws Error if the two have different bit depths.
  PairedSource(std::unique_ptr<FrameSource> first, std::unique_ptr<FrameSource> second);

  [[nodiscard]] FrameFormat format() const override { return source_->format(); }
  void start() override;
  Arrival next(Frame& frame, std::chrono::milliseconds timeout) override;
  void stop() override;
  void trigger() override;
  [[nodiscard]] SourceCounters counters() const override;
  [[nodiscard]] std::string state() const override;

 private:
  std::unique_ptr<FrameSource> second_;
  Frame held_first_, held_second_;
  bool has_first_ = false, has_second_ = false;
  std::atomic<std::uint64_t> paired_ = 0;  ///< read by other threads
};

}  // namespace slipstream
