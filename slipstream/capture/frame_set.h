#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "slipstream/image/image.h"

namespace slipstream {

/// Borrowed frames of one pixel type, in pattern order.
template <class Pixel>
using Frames = std::vector<ImageView<const Pixel>>;

/// The N frames of one scan, in pattern order: 8-bit, 9- to 16-bit, or unquantised (double, grey
/// levels of an 8-bit camera) as only a virtual camera gives them.
class FrameSet {
 public:
  using Images8 = std::vector<Image<std::uint8_t>>;
  using Images16 = std::vector<Image<std::uint16_t>>;
  using ImagesUnquantised = std::vector<Image<double>>;

  FrameSet() = default;
  /// Throws Error when the frames are of different sizes or `bits` do not fit the pixel.
  explicit FrameSet(Images8 images);
  FrameSet(Images16 images, int bits);
  explicit FrameSet(ImagesUnquantised images);

  [[nodiscard]] int count() const;
  [[nodiscard]] Size size() const;
  /// Bits per pixel of the camera; 8 for unquantised frames, whose grey levels are those of 8 bits.
  [[nodiscard]] int bits() const { return bits_; }
  /// Largest grey level, 2^bits - 1: a pixel that shows it may be saturated.
  [[nodiscard]] double full_scale() const { return (1 << bits_) - 1; }
  [[nodiscard]] bool quantised() const {
    return !std::holds_alternative<ImagesUnquantised>(images_);
  }

  /// Calls `visitor` with the frames [first, first + count) as `Frames<Pixel>`.
  template <class Visitor>
  auto visit(int first, int count, Visitor&& visitor) const {
    return std::visit(
        [&](const auto& images) {
          using Pixel = std::remove_cvref_t<decltype(*images[0].begin())>;
          return visitor(Frames<Pixel>(images.begin() + first, images.begin() + first + count));
        },
        images_);
  }
  template <class Visitor>
  auto visit(Visitor&& visitor) const {
    return visit(0, count(), visitor);
  }

 private:
  std::variant<Images8, Images16, ImagesUnquantised> images_;
  int bits_ = 8;
};

/// 1 where any frame shows the largest grey level, so that the true intensity may have been more.
/// Unquantised frames never do.
Image<std::uint8_t> saturation_mask(const FrameSet& frames);

}  // namespace slipstream
