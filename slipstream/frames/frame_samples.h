#pragma once

#include <cstddef>
#include <vector>

#include "slipstream/frames/frame.h"

namespace slipstream {

/// A few pixels, spread over the picture, by which frames are compared. They come in pairs: pixel
/// 2 i + 1 is a few pixels right of and below pixel 2 i.
class SampleGrid {
 public:
  static constexpr int pairs = 384;  ///< at most

  explicit SampleGrid(Size size);

  [[nodiscard]] std::size_t count() const { return pixels_.size(); }

  /// Grey levels of an 8-bit camera, into `samples`, which is made as long as count().
  void sample(const Frame& frame, std::vector<float>& samples) const;

 private:
  std::vector<std::size_t> pixels_;  ///< index in the picture
};

}  // namespace slipstream
