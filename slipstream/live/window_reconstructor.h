#pragma once

#include <optional>
#include <vector>

#include "slipstream/capture/frame.h"
#include "slipstream/capture/pool.h"
#include "slipstream/live/live_pipeline.h"
#include "slipstream/reconstruct/fused_reconstructor.h"
#include "slipstream/reconstruct/reconstructor.h"

namespace slipstream {

/// A window of frames to its cloud: by the fused pass, or in double precision where it cannot.
class WindowReconstructor {
 public:
  /// Throws Error where scanner, strategy or settings are not valid, or the scanner's camera does
  /// not take such frames.
  WindowReconstructor(const LiveScan& scan, const FrameFormat& format);

  [[nodiscard]] const LiveScan& scan() const { return scan_; }

  /// `window` in pattern order. The fused pass allocates nothing once `cloud` has been used. One
  /// thread at a time.
  void operator()(const std::vector<Pooled<Frame>>& window, FusedCloud& cloud);

 private:
  LiveScan scan_;
  std::optional<FusedReconstructor> fused_;
  std::optional<Reconstructor> in_double_;
  Frames<std::uint8_t> views8_;
  Frames<std::uint16_t> views16_;
};

}  // namespace slipstream
