#pragma once

#include <optional>

#include "slipstream/live/live_cloud.h"
#include "slipstream/live/live_pipeline.h"
#include "slipstream/reconstruct/reconstructor.h"

namespace slipstream::view {

/// Mean, modulation and phase of a cloud's frames, decoded again for display when they are looked
/// at.
class FrameDecoding {
 public:
  /// Throws Error as Reconstructor does.
  void look_for(const LiveScan& scan);

  /// What the frames of the cloud say; null where it has none or they are of another strategy, as
  /// those just before a change are. Valid until the next call.
  const FusedDecoding* operator()(const LiveCloud& cloud);

 private:
  std::optional<FusedReconstructor> fused_;
  std::optional<Reconstructor> in_double_;  ///< where there is no fused pass
  int frames_ = 0;
  FusedDecoding decoding_;
};

}  // namespace slipstream::view
