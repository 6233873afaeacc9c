#pragma once

#include <cstdint>
#include <functional>
#include <variant>
#include <vector>

#include "slipstream/image.h"

namespace slipstream {

/// Non-owning views of frames of one pixel type, in pattern order.
template <class Pixel>
using Frames = std::vector<ImageView<const Pixel>>;

/// Views of the frames of one scan in pattern order, with any stride: 8-bit, 9- to 16-bit, or
/// unquantised (double, 8-bit grey levels). All decoding takes these; FrameSet owns frames.
class FrameViews {
 public:
  FrameViews() = default;
  /// `bits` of 16-bit pixels. Throws Error if the frames have different sizes or it is not 8 to 16.
  template <class Pixel>
  FrameViews(Frames<Pixel> frames, int bits = 8);  // NOLINT(google-explicit-constructor)

  [[nodiscard]] int count() const;
  [[nodiscard]] Size size() const;
  /// Bits per camera pixel; 8 for unquantised frames, which use 8-bit grey levels.
  [[nodiscard]] int bits() const { return bits_; }
  /// Largest grey level, 2^bits - 1: a pixel at this level may be saturated.
  [[nodiscard]] double full_scale() const { return (1 << bits_) - 1; }
  /// For merged frames, see merge_exposures: brightness of each pixel relative to the shortest
  /// exposure. Otherwise empty.
  [[nodiscard]] const ImageView<const float>& gain() const { return gain_; }
  [[nodiscard]] bool merged() const { return gain_.width() > 0; }
  void set_gain(const ImageView<const float>& gain) { gain_ = gain; }
  /// Lowest grey level of possibly saturated pixels: full scale, or the mark in merged frames.
  [[nodiscard]] double saturation() const { return merged() ? merged_saturation : full_scale(); }
  static constexpr std::uint16_t merged_saturation = 65535;
  [[nodiscard]] bool quantised() const { return !std::holds_alternative<Frames<double>>(frames_); }

  /// The frames [first, first + count).
  [[nodiscard]] FrameViews part(int first, int count) const;

  /// Replaces the views; does not allocate if the number of frames is unchanged.
  template <class Pixel, class Owners, class ViewOf = std::identity>
  void assign(const Owners& owners, int bits, const ViewOf& view_of = {}) {
    // Same pixel type as before: the vector keeps its memory.
    if (!std::holds_alternative<Frames<Pixel>>(frames_)) frames_ = Frames<Pixel>();
    auto& views = std::get<Frames<Pixel>>(frames_);
    views.clear();
    for (const auto& owner : owners) views.emplace_back(view_of(owner));

    bits_ = bits;
    gain_ = {};
  }

  /// The frames with those indices, in that order.
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

/// 1 where any frame is at full scale, so the true intensity may be higher; 0 if unquantised.
Image<std::uint8_t> saturation_mask(const FrameViews& frames);

/// 1 where no frame is at either end of the grey levels, so that sums of frames are exact.
Image<std::uint8_t> unclipped_mask(const FrameViews& frames);

/// sum_n weights[n] I_n for every pixel, in grey levels, over the first `weights.size()` frames.
Image<double> weighted_sum(const FrameViews& frames, const std::vector<double>& weights);

/// The frames of one scan with their memory: see FrameViews.
class FrameSet {
 public:
  using Images8 = std::vector<Image<std::uint8_t>>;
  using Images16 = std::vector<Image<std::uint16_t>>;
  using ImagesUnquantised = std::vector<Image<double>>;

  FrameSet() = default;
  /// As for FrameViews. `gain`: of merged frames, see merged_exposures.
  template <class Pixel>
  FrameSet(std::vector<Image<Pixel>> images, int bits = 8, Image<float> gain = {});  // NOLINT

  /// Views of these frames; invalid once they move.
  [[nodiscard]] FrameViews views() const;
  operator FrameViews() const { return views(); }

  [[nodiscard]] int count() const { return views().count(); }
  [[nodiscard]] Size size() const { return views().size(); }
  /// See FrameViews.
  [[nodiscard]] int bits() const { return bits_; }
  [[nodiscard]] double full_scale() const { return views().full_scale(); }
  [[nodiscard]] bool quantised() const { return views().quantised(); }
  template <class Visitor>
  auto visit(Visitor&& visitor) const {
    return views().visit(std::forward<Visitor>(visitor));
  }

  friend FrameSet reordered(FrameSet frames, const std::vector<int>& order);
  friend std::vector<FrameSet> parts_of(FrameSet frames, const std::vector<int>& counts);
  friend FrameSet joined(std::vector<FrameSet> sets);

 private:
  std::variant<Images8, Images16, ImagesUnquantised> images_;
  int bits_ = 8;
  Image<float> gain_;
};

/// Whether `order` is a permutation of 0 to `count` - 1.
bool is_order_of(const std::vector<int>& order, int count);

/// Reorders the frames: frame n becomes the one at `order[n]`; copies no pixel. Throws Error unless
/// `order` is a permutation.
FrameSet reordered(FrameSet frames, const std::vector<int>& order);

/// Splits the frames into consecutive parts of these numbers of frames. Copies only the gain.
std::vector<FrameSet> parts_of(FrameSet frames, const std::vector<int>& counts);

/// Concatenates frame sets. Throws Error if their formats differ.
FrameSet joined(std::vector<FrameSet> sets);

/// Averages frame sets of one scene to reduce noise.
class MeanFrames {
 public:
  /// Throws Error if the set differs from the first in size, count or bits.
  void add(const FrameSet& frames);

  /// The mean of the added sets (at least one), unquantised, in 8-bit grey levels.
  [[nodiscard]] FrameSet mean() const;
  /// 1 where a frame of any set was saturated; the mean may not show it.
  [[nodiscard]] const Image<std::uint8_t>& saturated() const { return saturated_; }
  [[nodiscard]] int count() const { return count_; }

 private:
  int count_ = 0;
  int bits_ = 0;
  std::vector<Image<double>> sums_;
  Image<std::uint8_t> saturated_;
};

/// Merged frames and their views.
struct MergedFrames {
  FrameSet::Images16 images{};
  Image<float> gain{};
  FrameViews views{};
};

/// Merges frames of relative exposures t_e into one set, pixel by pixel: I_n = sum t_e I_n,e /
/// sqrt(sum t_e^2) over the exposures e without a saturated frame there. As the signal grows with
/// t_e and noise does not, these are inverse-variance weights: a merged frame has the noise of a
/// single one and a modulation sqrt(sum t_e^2) times the one at exposure 1. Merging before the
/// arctangent keeps the fringe order consistent. A pixel saturated in every exposure has the frames
/// of the shortest one, marked as saturated. `frames` are ordered by exposure, at most 16; merged
/// ones have 14 bits and a gain: see FrameViews. Reuses memory. Throws Error unless there are
/// equally many quantised frames for each exposure.
void merge_exposures(const FrameViews& frames, const std::vector<double>& exposures,
                     MergedFrames& merged);

/// One-off version with its own memory.
FrameSet merged_exposures(const FrameViews& frames, const std::vector<double>& exposures);

}  // namespace slipstream
