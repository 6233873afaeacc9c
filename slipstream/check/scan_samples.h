#pragma once

#include <vector>

#include "slipstream/frames/frame_set.h"

namespace slipstream {

/// A few lit pixels of a scan, spread over the picture, each with neighbours: what a scan is judged
/// by. Grey levels are those of an 8-bit camera.
class ScanSamples {
 public:
  /// The pixels of a group. A neighbour tells what is noise, which it does not share; a far one
  /// whether the coordinate goes on.
  enum Place { middle, right, below, far_right, far_below };
  static constexpr int places = 5;
  /// Fewer groups than these tell nothing.
  static constexpr std::size_t fewest_groups = 64;

  /// How many pixels to look at, and when a pixel is lit: its frames differ by `least_range` grey
  /// levels of 255.
  struct Effort {
    int most_looked = 16384;
    int fewest_looked = 2048;
    int lit_wanted = 768;
    double least_range = 22;
    /// Whether neighbours in other rows and far ones are read; unread ones count as unlit.
    bool all_places = true;
  };

  /// For pictures of that size; nothing is sampled yet.
  ScanSamples(Size size, int frames);

  /// Samples anew; memory is used again.
  void take(const FrameViews& frames, const Effort& effort);

  [[nodiscard]] int frames() const { return frames_; }
  /// Of lit pixels, none of whose frames is saturated.
  [[nodiscard]] std::size_t groups() const { return lit_.size(); }
  /// The intensities of the frames, in their order.
  [[nodiscard]] const float* levels(std::size_t group, Place place) const {
    return levels_.data() +
           (group * places + static_cast<std::size_t>(place)) * static_cast<std::size_t>(frames_);
  }
  [[nodiscard]] int column(std::size_t group) const { return lit_[group].column; }
  [[nodiscard]] int row(std::size_t group) const { return lit_[group].row; }
  /// Whether the pixel there is lit.
  [[nodiscard]] bool lit(std::size_t group, Place place) const;

  /// Pixels looked at with a saturated frame, though lit.
  [[nodiscard]] int saturated() const { return saturated_; }
  /// Share of the pixels looked at that are lit, saturated ones among them.
  [[nodiscard]] double lit_share() const;
  /// Of the lit pixels.
  [[nodiscard]] double saturated_share() const;
  /// The brightest intensity seen, and the largest range of a pixel's frames.
  [[nodiscard]] double brightest() const { return brightest_; }
  [[nodiscard]] double largest_range() const { return largest_range_; }
  /// Sums of each frame over all pixels looked at.
  [[nodiscard]] const std::vector<double>& sums() const { return sums_; }

 private:
  struct Pixel {
    int column = 0, row = 0;
  };

  [[nodiscard]] Pixel pixel(int i) const;
  [[nodiscard]] double range(const float* levels) const;

  Size size_;
  int frames_;
  int far_;  ///< distance from the middle to the far places, pixels
  double least_range_ = 0;
  std::vector<Pixel> lit_;
  std::vector<float> levels_;
  std::vector<float> one_;  ///< the intensities of one pixel
  int looked_ = 0, saturated_ = 0;
  double brightest_ = 0, largest_range_ = 0;
  std::vector<double> sums_;
};

}  // namespace slipstream
