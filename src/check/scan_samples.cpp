#include "check/scan_samples.h"

#include <array>
#include <span>

#include "base/statistics.h"

namespace slipstream {

ScanSamples::ScanSamples(Size size, int frames)
    : size_(size),
      frames_(frames),
      far_(std::max(3, std::max(size.width, size.height) / 64)),
      one_(frames),
      sums_(frames) {}

ScanSamples::Pixel ScanSamples::pixel(int i) const {
  const auto [x, y] = spread_place(i);

  // Leave room for the far neighbours, on small pictures for fewer of them.
  const auto place = [&](double part, int length) {
    return static_cast<int>(part * (length - std::min(far_, length / 8)));
  };

  return {place(x, size_.width), place(y, size_.height)};
}

double ScanSamples::range(const float* levels) const {
  const auto [least, greatest] = std::minmax_element(levels, levels + frames_);
  return static_cast<double>(*greatest) - *least;
}

bool ScanSamples::lit(std::size_t group, Place place) const {
  return range(levels(group, place)) >= least_range_;
}

double ScanSamples::lit_share() const {
  return looked_ == 0 ? 0 : static_cast<double>(groups() + saturated_) / looked_;
}

double ScanSamples::saturated_share() const {
  const double lit = static_cast<double>(groups()) + saturated_;
  // An all-white picture contains no pattern.
  if (lit == 0) return brightest_ >= 255 ? 1 : 0;
  return saturated_ / lit;
}

double ScanSamples::dim_share() const {
  const double dim = dim_;
  return dim == 0 ? 0 : dim / (dim + static_cast<double>(groups()) + saturated_);
}

void ScanSamples::take(const FrameViews& frames, const Effort& effort) {
  least_range_ = effort.least_range;
  lit_.clear();
  levels_.clear();
  looked_ = saturated_ = dim_ = 0;
  brightest_ = largest_range_ = 0;
  std::ranges::fill(sums_, 0.0);

  const double grey_level = frames.full_scale() / 255;
  const bool saturates = frames.quantised();
  frames.visit([&](const auto& views) {
    // Reads a pixel; true if a frame is saturated. In merged frames, such a level is only a mark.
    const auto read = [&](int column, int row) {
      column = std::min(column, size_.width - 1);
      row = std::min(row, size_.height - 1);

      double greatest = 0;
      for (std::size_t n = 0; n < one_.size(); ++n) {
        const auto level = static_cast<double>(views[n](column, row));
        greatest = std::max(greatest, level);
        one_[n] = static_cast<float>(level / grey_level);
      }
      return saturates && greatest >= frames.saturation();
    };

    // Enough pixels to judge shares by, then on until enough of them are lit.
    while (looked_ < effort.most_looked &&
           (looked_ < effort.fewest_looked || static_cast<int>(lit_.size()) < effort.lit_wanted)) {
      const Pixel at = pixel(looked_++);
      const bool saturated = read(at.column, at.row);

      // 1. Statistics of all pixels read.
      for (std::size_t n = 0; n < one_.size(); ++n) sums_[n] += one_[n];
      const double greatest = *std::ranges::max_element(one_);
      brightest_ = std::max(brightest_, frames.merged() ? std::min(greatest, 255.0) : greatest);
      largest_range_ = std::max(largest_range_, range(one_.data()));

      // 2. Unlit pixels: dim ones change in the same frames as their neighbour.
      if (range(one_.data()) < least_range_) {
        // Above the range of noise with a variance up to 1.6. Stronger noise rarely changes the
        // neighbour in the same frames.
        constexpr double above_noise = 8;

        const auto [least, most] = std::ranges::minmax_element(one_);
        if (!effort.all_places || *most - *least < above_noise) continue;
        // Both point into `one_`: from here on to the neighbour's levels in these two frames.
        if (!read(at.column + 1, at.row) && *most - *least > above_noise / 2) ++dim_;
        continue;
      }

      if (saturated) {
        ++saturated_;
        continue;
      }

      // 3. Lit pixels, with their neighbours.
      lit_.push_back(at);
      if (frames.merged()) lit_.back().gain = frames.gain()(at.column, at.row);

      constexpr std::array<std::array<int, 2>, places> steps{
          {{0, 0}, {1, 0}, {0, 1}, {1, 1}, {-1, 0}, {0, -1}}};
      const std::size_t wanted = effort.all_places ? places : 2;
      for (const auto& [dx, dy] : std::span(steps).first(wanted)) {
        // Clipped neighbours do not match the patterns either: zeros count as unlit.
        if (read(at.column + (dx < 0 ? far_ : dx), at.row + (dy < 0 ? far_ : dy))) {
          std::ranges::fill(one_, 0.0F);
        }
        levels_.insert(levels_.end(), one_.begin(), one_.end());
      }

      levels_.resize(lit_.size() * places * one_.size());
    }
  });
}

void ScanSamples::reorder(const std::vector<int>& order) {
  for (auto pixel = levels_.begin(); pixel != levels_.end(); pixel += frames_) {
    std::copy_n(pixel, frames_, one_.begin());
    for (std::size_t n = 0; n < order.size(); ++n) pixel[n] = one_[order[n]];
  }
}

}  // namespace slipstream
