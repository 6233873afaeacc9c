#pragma once

#include <cstdint>
#include <utility>
#include <variant>
#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/frames/frame_views.h"

namespace slipstream {

/// The frames of one scan with their memory: see FrameViews, which it gives.
class FrameSet {
 public:
  using Images8 = std::vector<Image<std::uint8_t>>;
  using Images16 = std::vector<Image<std::uint16_t>>;
  using ImagesUnquantised = std::vector<Image<double>>;

  FrameSet() = default;
  /// Throws Error when the frames are of different sizes or `bits` do not fit the pixel.
  explicit FrameSet(Images8 images);
  FrameSet(Images16 images, int bits);
  /// Merged frames: see merged_exposures.
  FrameSet(Images16 images, int bits, Image<float> gain);
  explicit FrameSet(ImagesUnquantised images);

  /// Of these frames, where they stand now.
  [[nodiscard]] FrameViews views() const;
  operator FrameViews() const { return views(); }

  [[nodiscard]] int count() const;
  [[nodiscard]] Size size() const;
  /// See FrameViews.
  [[nodiscard]] int bits() const { return bits_; }
  [[nodiscard]] double full_scale() const { return (1 << bits_) - 1; }
  [[nodiscard]] bool quantised() const {
    return !std::holds_alternative<ImagesUnquantised>(images_);
  }

  /// Calls `visitor` with the frames as `Frames<Pixel>`.
  template <class Visitor>
  auto visit(Visitor&& visitor) const {
    return views().visit(std::forward<Visitor>(visitor));
  }

  friend FrameSet reordered(FrameSet frames, const std::vector<int>& order);
  friend std::pair<FrameSet, FrameSet> halves(FrameSet frames);

 private:
  std::variant<Images8, Images16, ImagesUnquantised> images_;
  int bits_ = 8;
  Image<float> gain_;
};

/// Whether it has each of 0 to `count` - 1 in it, once.
bool is_order_of(const std::vector<int>& order, int count);

/// The same frames, of which frame n is the one that was at place `order[n]`. No pixel is copied.
/// Throws Error unless it is an order of so many.
FrameSet reordered(FrameSet frames, const std::vector<int>& order);

/// The first half of the frames and the second, of an even number. No pixel but the gain is copied.
std::pair<FrameSet, FrameSet> halves(FrameSet frames);

}  // namespace slipstream
