#pragma once

#include <array>
#include <cstdint>
#include <mutex>

#include "slipstream/frame_set.h"
#include "slipstream/image.h"

namespace slipstream {

/// Red, green and blue, grey levels of 255.
using ColourLevels = std::array<float, 3>;

/// Factors of red, green and blue.
using WhiteBalance = std::array<double, 3>;

/// The mean of pictures in colour. Pictures may be added from several threads, in any order.
class ColourMean {
 public:
  /// Red, green and blue side by side. Ignores a picture of another size than the first.
  template <class Pixel>
  void add(const Image<Pixel>& rgb);

  /// Empty without pictures, or if they are grey. `full_scale`: of the pictures' levels.
  [[nodiscard]] Image<ColourLevels> levels(double full_scale) const;

 private:
  std::mutex mutex_;  ///< guards the members below
  Image<std::uint32_t> sums_;
  std::uint32_t count_ = 0;
};

extern template void ColourMean::add(const Image<std::uint8_t>&);
extern template void ColourMean::add(const Image<std::uint16_t>&);

/// The levels of three frames: red, green and blue.
Image<ColourLevels> colour_levels(const FrameViews& channels);

/// The factors, at least 1, that make the mean of a patch grey. Throws Error if the patch is not in
/// the picture, dark or saturated.
WhiteBalance white_balance(const Image<ColourLevels>& levels, const Rectangle& grey_patch);

/// The levels in 8 bits, balanced, rounded and clipped.
Image<Colour> balanced(const Image<ColourLevels>& levels, const WhiteBalance& balance);

}  // namespace slipstream
