#pragma once

#include <cstdint>
#include <utility>
#include <variant>
#include <vector>

#include "slipstream/base/image.h"

namespace slipstream {

/// Borrowed frames of one pixel type, in pattern order.
template <class Pixel>
using Frames = std::vector<ImageView<const Pixel>>;

/// The frames of one scan, in pattern order, wherever they stand in memory and with any stride:
/// 8-bit, 9- to 16-bit, or unquantised (double, grey levels of an 8-bit camera). Valid as long as
/// their memory is. All that decodes takes these; FrameSet owns frames and gives them.
class FrameViews {
 public:
  FrameViews() = default;
  /// Throws Error when the frames are of different sizes or `bits` are not 8 to 16.
  FrameViews(Frames<std::uint8_t> frames);  // NOLINT(google-explicit-constructor)
  FrameViews(Frames<std::uint16_t> frames, int bits);
  FrameViews(Frames<double> frames);  // NOLINT(google-explicit-constructor)

  [[nodiscard]] int count() const;
  [[nodiscard]] Size size() const;
  /// Bits per pixel of the camera; 8 for unquantised frames, whose grey levels are those of 8 bits.
  [[nodiscard]] int bits() const { return bits_; }
  /// Largest grey level, 2^bits - 1: a pixel that shows it may be saturated.
  [[nodiscard]] double full_scale() const { return (1 << bits_) - 1; }
  /// Merged frames, see merge_exposures: how many times as bright as in the shortest exposure each
  /// pixel is in them. Empty where the frames are as a camera gave them.
  [[nodiscard]] const ImageView<const float>& gain() const { return gain_; }
  [[nodiscard]] bool merged() const { return gain_.width() > 0; }
  void set_gain(const ImageView<const float>& gain) { gain_ = gain; }
  /// The grey level from which on a pixel may be saturated: the full scale, but in merged frames,
  /// which go beyond it and mark saturated pixels so.
  [[nodiscard]] double saturation() const { return merged() ? merged_saturation : full_scale(); }
  static constexpr std::uint16_t merged_saturation = 65535;
  [[nodiscard]] bool quantised() const { return !std::holds_alternative<Frames<double>>(frames_); }

  /// The frames [first, first + count).
  [[nodiscard]] FrameViews part(int first, int count) const;

  /// Takes the place of what was there: allocates nothing where as many frames were before.
  template <class Pixel, class Owners, class ViewOf>
  void assign(const Owners& owners, int bits, const ViewOf& view_of) {
    if (!std::holds_alternative<Frames<Pixel>>(frames_)) frames_ = Frames<Pixel>();
    auto& views = std::get<Frames<Pixel>>(frames_);
    views.clear();
    for (const auto& owner : owners) views.push_back(view_of(owner));
    bits_ = bits;
    gain_ = {};
  }

  /// Those frames, in that order.
  [[nodiscard]] FrameViews chosen(const std::vector<int>& frames) const;

  /// Calls `visitor` with the frames as `Frames<Pixel>`.
  template <class Visitor>
  decltype(auto) visit(Visitor&& visitor) const {
    return std::visit(std::forward<Visitor>(visitor), frames_);
  }

 private:
  std::variant<Frames<std::uint8_t>, Frames<std::uint16_t>, Frames<double>> frames_;
  int bits_ = 8;
  ImageView<const float> gain_{};
};

/// 1 where any frame shows the largest grey level, so that the true intensity may have been more.
/// Unquantised frames never do.
Image<std::uint8_t> saturation_mask(const FrameViews& frames);

/// 1 where no frame is at either end of the grey levels, so that sums of them are right.
Image<std::uint8_t> unclipped_mask(const FrameViews& frames);

/// sum_n weights[n] I_n of every pixel, grey levels of the frames; the first `weights.size()` of
/// them.
Image<double> weighted_sum(const FrameViews& frames, const std::vector<double>& weights);

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
