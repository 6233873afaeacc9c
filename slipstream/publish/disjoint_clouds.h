#pragma once

#include <cstdint>
#include <optional>

#include "slipstream/live/live_cloud.h"

namespace slipstream {

/// Of clouds that come one after the other, those that share no frame with the one chosen before.
class DisjointClouds {
 public:
  bool is_next(const LiveCloud& cloud) {
    const std::uint64_t newest = cloud.newest.sequence, frames = cloud.frames.size();
    const bool wanted = !last_ || newest < *last_ || newest - *last_ >= frames;
    if (wanted) last_ = newest;
    return wanted;
  }

 private:
  std::optional<std::uint64_t> last_;  ///< sequence of the newest frame of the one chosen last
};

}  // namespace slipstream
