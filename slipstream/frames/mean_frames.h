#pragma once

#include <cstdint>
#include <vector>

#include "slipstream/frames/frame_set.h"

namespace slipstream {

/// Sums frame sets of one scene as they come, so that their noise averages out.
class MeanFrames {
 public:
  /// Throws Error when the set differs from the first in size, count or bits.
  void add(const FrameSet& frames);

  /// The mean of the sets added (at least one), unquantised, in grey levels of 8 bits.
  [[nodiscard]] FrameSet mean() const;
  /// 1 where a frame of any set was saturated, which its mean may not show.
  [[nodiscard]] const Image<std::uint8_t>& saturated() const { return saturated_; }
  [[nodiscard]] int count() const { return count_; }

 private:
  int count_ = 0;
  int bits_ = 0;
  std::vector<Image<double>> sums_;
  Image<std::uint8_t> saturated_;
};

}  // namespace slipstream
