#pragma once

#include <algorithm>
#include <vector>

#include "slipstream/frame_set.h"

namespace slipstream {

/// Lit pixels of a scan, spread over the picture, each with neighbours: the input of the scan
/// check. Grey levels are scaled to 8 bits.
class ScanSamples {
 public:
  /// The pixels of a group. Adjacent pixels separate signal from noise, which they do not share;
  /// far ones show whether the coordinate is continuous.
  enum Place { middle, right, below, right_below, far_right, far_below };
  static constexpr int places = 6;
  /// Minimum number of groups for a check.
  static constexpr std::size_t fewest_groups = 64;

  /// How many pixels to read. A pixel is lit if its frames differ by `least_range` grey levels of
  /// 255.
  struct Effort {
    int most_looked = 16384, fewest_looked = 2048, lit_wanted = 768;
    double least_range = 22;
    /// Whether to read neighbours in other rows and far ones; unread ones count as unlit.
    bool all_places = true;
  };

  /// `size`: of the pictures. Call take() to sample.
  ScanSamples(Size size, int frames);

  /// Replaces the samples; reuses memory.
  void take(const FrameViews& frames, const Effort& effort);
  /// Puts the frames in that order: frame n becomes the one at `order[n]`.
  void reorder(const std::vector<int>& order);
  /// Drops the groups from `count` on; the first ones are spread over the picture, too.
  void keep_first(std::size_t count) {
    lit_.resize(std::min(count, lit_.size()));
    levels_.resize(lit_.size() * places * frames_);
  }

  [[nodiscard]] int frames() const { return frames_; }
  [[nodiscard]] Size size() const { return size_; }
  /// Number of lit pixels without a saturated frame.
  [[nodiscard]] std::size_t groups() const { return lit_.size(); }
  /// Intensities of the frames, in order.
  [[nodiscard]] const float* levels(std::size_t group, Place place) const {
    return levels_.data() + (group * places + place) * frames_;
  }

  /// Applies `change(float* levels, double down)` to each pixel of the groups; `down`: its row,
  /// share of the picture's height.
  template <class Change>
  void change(const Change& change) {
    for (std::size_t i = 0; i < lit_.size() * places; ++i) {
      change(levels_.data() + i * frames_, down(i / places));
    }
  }

  [[nodiscard]] int column(std::size_t group) const { return lit_[group].column; }
  [[nodiscard]] int row(std::size_t group) const { return lit_[group].row; }
  /// The row as a share of the picture's height.
  [[nodiscard]] double down(std::size_t group) const {
    return static_cast<double>(row(group)) / size_.height;
  }
  /// Brightness of merged frames relative to the shortest exposure; otherwise 1.
  [[nodiscard]] double gain(std::size_t group) const { return lit_[group].gain; }
  /// Difference of the brightest and the darkest frame.
  [[nodiscard]] double range(const float* levels) const;
  /// Sum of squares about the mean over the frames.
  [[nodiscard]] double variation(const float* levels) const;
  [[nodiscard]] bool lit(std::size_t group, Place place) const;

  /// Number of lit pixels with a saturated frame.
  [[nodiscard]] int saturated() const { return saturated_; }
  /// Share of the pixels read that are lit, saturated or not.
  [[nodiscard]] double lit_share() const;
  /// Share of the lit pixels.
  [[nodiscard]] double saturated_share() const;
  /// Share of the dim and lit pixels that change like their neighbours but too little to be lit.
  [[nodiscard]] double dim_share() const;
  /// The brightest intensity, and the largest difference between the frames of a pixel.
  [[nodiscard]] double brightest() const { return brightest_; }
  [[nodiscard]] double largest_range() const { return largest_range_; }
  /// Sum of each frame over all pixels read.
  [[nodiscard]] const std::vector<double>& sums() const { return sums_; }

 private:
  struct Pixel {
    int column = 0, row = 0;
    double gain = 1;
  };

  /// Takes the samples from frames of one type of pixels.
  template <class Views>
  class Reader;

  [[nodiscard]] Pixel pixel(int i) const;

  Size size_;
  int frames_;
  int far_;  ///< distance from the middle to the far places, pixels
  double least_range_ = 0;
  std::vector<Pixel> lit_;
  std::vector<float> levels_;
  std::vector<float> one_;  ///< the intensities of one pixel
  int looked_ = 0, saturated_ = 0, dim_ = 0;
  double brightest_ = 0, largest_range_ = 0;
  std::vector<double> sums_;
};

}  // namespace slipstream
