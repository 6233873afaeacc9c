#pragma once

#include <chrono>
#include <memory>

#include "slipstream/cloud/cloud.h"
#include "slipstream/cloud/uncertainty.h"
#include "slipstream/frames/frame_views.h"

namespace slipstream::view {

/// A cloud to be shown, and the frames that it was made of where there are any. A copy shares both:
/// neither changes, and both stay in memory, as long as there is one.
struct ShownCloud {
  std::shared_ptr<const Cloud> cloud{};              ///< keeps the memory of the frames too
  std::shared_ptr<const Uncertainty> uncertainty{};  ///< where it came with the cloud
  FrameViews frames{};  ///< in pattern order; none of a cloud from a file
  std::chrono::steady_clock::time_point
      captured{};  ///< when the newest frame was; 0 without frames

  /// False before there is a first cloud.
  explicit operator bool() const { return cloud != nullptr; }
  /// Whether it is the very same cloud, not one like it.
  [[nodiscard]] bool is(const ShownCloud& other) const { return cloud == other.cloud; }
};

}  // namespace slipstream::view
