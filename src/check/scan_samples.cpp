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

double ScanSamples::variation(const float* levels) const {
  double sum = 0, squares = 0;

  for (int n = 0; n < frames_; ++n) {
    const double level = levels[n];
    sum += level;
    squares += level * level;
  }

  return squares - sum * sum / frames_;
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

template <class Views>
class ScanSamples::Reader {
 public:
  Reader(ScanSamples& samples, const FrameViews& frames, const Views& views, const Effort& effort)
      : samples_(samples),
        frames_(frames),
        views_(views),
        effort_(effort),
        grey_level_(frames.full_scale() / 255),
        saturates_(frames.quantised()) {}

  /// Takes the pixel into the statistics, and a lit one with its neighbours.
  void take(const Pixel& at) {
    const bool saturated = read(at.column, at.row);
    add_to_statistics();

    if (samples_.range(one().data()) < samples_.least_range_) {
      if (is_dim(at)) ++samples_.dim_;
    } else if (saturated) {
      ++samples_.saturated_;
    } else {
      add_lit(at);
    }
  }

 private:
  /// The levels of the pixel read last.
  std::vector<float>& one() { return samples_.one_; }

  /// Reads a pixel; true if a frame is saturated. In merged frames, such a level is only a mark.
  bool read(int column, int row) {
    column = std::min(column, samples_.size_.width - 1);
    row = std::min(row, samples_.size_.height - 1);

    double greatest = 0;
    for (std::size_t n = 0; n < one().size(); ++n) {
      const auto level = static_cast<double>(views_[n](column, row));
      greatest = std::max(greatest, level);
      one()[n] = static_cast<float>(level / grey_level_);
    }

    return saturates_ && greatest >= frames_.saturation();
  }

  void add_to_statistics() {
    for (std::size_t n = 0; n < one().size(); ++n) samples_.sums_[n] += one()[n];

    const double greatest = *std::ranges::max_element(one());
    samples_.brightest_ =
        std::max(samples_.brightest_, frames_.merged() ? std::min(greatest, 255.0) : greatest);
    samples_.largest_range_ = std::max(samples_.largest_range_, samples_.range(one().data()));
  }

  /// Whether an unlit pixel is dim: it changes in the same frames as its neighbour.
  bool is_dim(const Pixel& at) {
    // Above the range of noise with a variance up to 1.6. Stronger noise rarely changes the
    // neighbour in the same frames.
    constexpr double above_noise = 8;

    const auto [least, most] = std::ranges::minmax_element(one());
    if (!effort_.all_places || *most - *least < above_noise) return false;

    // Both point into the levels read: from here on to the neighbour's in these two frames.
    return !read(at.column + 1, at.row) && *most - *least > above_noise / 2;
  }

  void add_lit(const Pixel& at) {
    samples_.lit_.push_back(at);
    if (frames_.merged()) samples_.lit_.back().gain = frames_.gain()(at.column, at.row);

    constexpr std::array<std::array<int, 2>, places> steps{
        {{0, 0}, {1, 0}, {0, 1}, {1, 1}, {-1, 0}, {0, -1}}};
    const std::size_t wanted = effort_.all_places ? places : 2;
    const int far = samples_.far_;
    std::vector<float>& levels = samples_.levels_;

    for (const auto& [dx, dy] : std::span(steps).first(wanted)) {
      // Clipped neighbours do not match the patterns either: zeros count as unlit.
      if (read(at.column + (dx < 0 ? far : dx), at.row + (dy < 0 ? far : dy))) {
        std::ranges::fill(one(), 0.0F);
      }
      levels.insert(levels.end(), one().begin(), one().end());
    }

    levels.resize(samples_.lit_.size() * places * one().size());
  }

  ScanSamples& samples_;
  const FrameViews& frames_;
  const Views& views_;
  const Effort& effort_;
  double grey_level_;  ///< one of 255
  bool saturates_;
};

void ScanSamples::take(const FrameViews& frames, const Effort& effort) {
  least_range_ = effort.least_range;
  lit_.clear();
  levels_.clear();
  looked_ = saturated_ = dim_ = 0;
  brightest_ = largest_range_ = 0;
  std::ranges::fill(sums_, 0.0);

  frames.visit([&](const auto& views) {
    Reader reader(*this, frames, views, effort);

    // Enough pixels to judge shares by, then on until enough of them are lit.
    while (looked_ < effort.most_looked &&
           (looked_ < effort.fewest_looked || static_cast<int>(lit_.size()) < effort.lit_wanted)) {
      reader.take(pixel(looked_++));
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
