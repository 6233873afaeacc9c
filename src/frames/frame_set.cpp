#include "slipstream/frame_set.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <span>
#include <type_traits>

#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

template <class Images>
void require_same_size(const Images& frames) {
  for (const auto& frame : frames) {
    throw_if(frame.size() != frames.front().size(),
             "frame {} is {}x{}, the first {}x{}; expected equal sizes", &frame - frames.data(),
             frame.width(), frame.height(), frames.front().width(), frames.front().height());
  }
}

/// Calls `body` with the level and position of every pixel of every frame.
template <class Body>
void for_each_level(const FrameViews& frames, const Body& body) {
  frames.visit([&](const auto& views) {
    for (const auto& view : views) {
      for_each_pixel_in_order(view.size(), [&](int column, int row) {
        body(static_cast<double>(view(column, row)), column, row);
      });
    }
  });
}

/// Bit depth of frames of this type; `bits` for 16-bit pixels.
template <class Pixel>
int bits_of(int bits) {
  if (!std::is_same_v<Pixel, std::uint16_t>) return 8;
  throw_if(bits < 8 || bits > 16, "{} bits per camera pixel are out of range; 8 to 16", bits);
  return bits;
}

/// A merged level is at most sqrt(16) full scales: these bits, stored in 16.
constexpr int merged_bits = 14;
constexpr std::size_t most_exposures = 16;
/// Pixels merged at a time, so that their weights stay on the stack.
constexpr int tile = 128;
using TileRow = std::array<float, tile>;

template <class Pixel>
struct Merge {
  const Frames<Pixel>& frames;
  const std::vector<double>& exposures;
  Pixel full;
  float scale;  ///< merged grey levels per input grey level
  MergedFrames& merged;

  [[nodiscard]] std::size_t count() const { return frames.size() / exposures.size(); }
  [[nodiscard]] std::size_t shortest() const {
    return std::ranges::min_element(exposures) - exposures.begin();
  }
  [[nodiscard]] const Pixel* levels(std::size_t e, std::size_t n, int row, int first) const {
    return frames[e * count() + n].row(row) + first;
  }

  /// t_e where exposure e has no saturated frame, otherwise 0.
  void weigh(std::size_t e, int row, int first, int width, TileRow& weights) const {
    std::array<Pixel, tile> greatest{};
    for (std::size_t n = 0; n < count(); ++n) {
      const Pixel* const I = levels(e, n, row, first);
      for (int i = 0; i < width; ++i) greatest[i] = std::max(greatest[i], I[i]);
    }

    const auto t = static_cast<float>(exposures[e]);
    for (int i = 0; i < width; ++i) weights[i] = greatest[i] < full ? t : 0;
  }

  void operator()(int row, int first, int width) const {
    // 1. Weights of the exposures, and the sum of their squares.
    std::array<TileRow, most_exposures> weights;
    TileRow squares{};
    for (std::size_t e = 0; e < exposures.size(); ++e) {
      weigh(e, row, first, width, weights[e]);
      for (int i = 0; i < width; ++i) squares[i] += weights[e][i] * weights[e][i];
    }

    // 2. Pixels saturated in every exposure take the shortest one.
    const auto least = static_cast<float>(exposures[shortest()]);
    TileRow saturated{};
    for (int i = 0; i < width; ++i) {
      saturated[i] = squares[i] == 0 ? 1 : 0;
      weights[shortest()][i] += saturated[i] * least;
      squares[i] += saturated[i] * least * least;
    }

    // 3. Brightness relative to the shortest exposure, and the norm of the weights.
    float* const gain = merged.gain.row(row) + first;
    TileRow norms;
    for (int i = 0; i < width; ++i) {
      gain[i] = std::sqrt(squares[i]) / least;
      norms[i] = scale / std::sqrt(squares[i]);
    }

    // 4. The merged frames.
    for (std::size_t n = 0; n < count(); ++n) sum(n, row, first, width, weights, norms, saturated);
  }

  void sum(std::size_t n, int row, int first, int width,
           const std::array<TileRow, most_exposures>& weights, const TileRow& norms,
           const TileRow& saturated) const {
    constexpr float marked = FrameViews::merged_saturation;

    TileRow sums{};
    for (std::size_t e = 0; e < exposures.size(); ++e) {
      const Pixel* const I = levels(e, n, row, first);
      for (int i = 0; i < width; ++i) sums[i] += weights[e][i] * static_cast<float>(I[i]);
    }

    const Pixel* const shortly = levels(shortest(), n, row, first);
    std::uint16_t* const merged_levels = merged.images[n].row(row) + first;
    for (int i = 0; i < width; ++i) {
      const float level = norms[i] * sums[i] + 0.5F;

      const bool clipped = saturated[i] != 0 && shortly[i] >= full;
      merged_levels[i] = static_cast<std::uint16_t>(clipped ? marked : std::min(level, marked - 1));
    }
  }
};

}  // namespace

template <class Pixel>
FrameViews::FrameViews(Frames<Pixel> frames, int bits)
    : frames_(std::move(frames)), bits_(bits_of<Pixel>(bits)) {
  require_same_size(std::get<Frames<Pixel>>(frames_));
}

template FrameViews::FrameViews(Frames<std::uint8_t> frames, int bits);
template FrameViews::FrameViews(Frames<std::uint16_t> frames, int bits);
template FrameViews::FrameViews(Frames<double> frames, int bits);

int FrameViews::count() const {
  return visit([](const auto& views) { return static_cast<int>(views.size()); });
}

Size FrameViews::size() const {
  return visit([](const auto& views) { return views.empty() ? Size{} : views.front().size(); });
}

FrameViews FrameViews::chosen(const std::vector<int>& frames) const {
  FrameViews chosen = *this;
  std::visit(
      [&](auto& views) {
        const auto all = views;
        views.clear();
        for (const int n : frames) views.push_back(all[n]);
      },
      chosen.frames_);

  return chosen;
}

FrameViews FrameViews::part(int first, int count) const {
  std::vector<int> frames(count);
  std::iota(frames.begin(), frames.end(), first);
  return chosen(frames);
}

Image<std::uint8_t> saturation_mask(const FrameViews& frames) {
  Image<std::uint8_t> mask(frames.size());
  if (!frames.quantised()) return mask;

  // In the frames' own numbers, many at a time.
  frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    const auto saturation = static_cast<Pixel>(frames.saturation());
    for (const ImageView<const Pixel>& view : views) {
      for (int row = 0; row < mask.height(); ++row) {
        std::transform(view.row(row), view.row(row) + view.width(), mask.row(row), mask.row(row),
                       [&](Pixel level, std::uint8_t before) -> std::uint8_t {
                         return level >= saturation ? 1 : before;
                       });
      }
    }
  });

  return mask;
}

Image<std::uint8_t> unclipped_mask(const FrameViews& frames) {
  Image<std::uint8_t> mask(frames.size(), 1);

  for_each_level(frames, [&](double level, int column, int row) {
    if (level <= 0 || (frames.quantised() && level >= frames.saturation())) mask(column, row) = 0;
  });

  return mask;
}

Image<double> weighted_sum(const FrameViews& frames, const std::vector<double>& weights) {
  Image<double> sums(frames.size());

  frames.visit([&](const auto& views) {
    for_each_row(sums.height(), [&](int row) {
      for (std::size_t n = 0; n < weights.size(); ++n) {
        if (weights[n] == 0) continue;
        for (int column = 0; column < sums.width(); ++column) {
          sums(column, row) += weights[n] * static_cast<double>(views[n](column, row));
        }
      }
    });
  });

  return sums;
}

template <class Pixel>
FrameSet::FrameSet(std::vector<Image<Pixel>> images, int bits, Image<float> gain)
    : images_(std::move(images)), bits_(bits_of<Pixel>(bits)), gain_(std::move(gain)) {
  require_same_size(std::get<std::vector<Image<Pixel>>>(images_));
}

template FrameSet::FrameSet(Images8 images, int bits, Image<float> gain);
template FrameSet::FrameSet(Images16 images, int bits, Image<float> gain);
template FrameSet::FrameSet(ImagesUnquantised images, int bits, Image<float> gain);

FrameViews FrameSet::views() const {
  return std::visit(
      [&](const auto& images) {
        using Pixel = std::remove_cvref_t<decltype(*images[0].begin())>;

        FrameViews views;
        views.assign<Pixel>(images, bits_);
        views.set_gain(gain_);
        return views;
      },
      images_);
}

bool is_order_of(const std::vector<int>& order, int count) {
  std::vector<int> all(count);
  std::iota(all.begin(), all.end(), 0);
  return std::is_permutation(order.begin(), order.end(), all.begin(), all.end());
}

FrameSet reordered(FrameSet frames, const std::vector<int>& order) {
  throw_if(!is_order_of(order, frames.count()),
           "the order of {} frames must contain each of 0 to {} once", frames.count(),
           frames.count() - 1);

  std::visit(
      [&](auto& images) {
        std::remove_cvref_t<decltype(images)> ordered;
        ordered.reserve(images.size());
        for (const int place : order) ordered.push_back(std::move(images[place]));
        images = std::move(ordered);
      },
      frames.images_);

  return frames;
}

std::vector<FrameSet> parts_of(FrameSet frames, const std::vector<int>& counts) {
  std::vector<FrameSet> parts(counts.size());

  std::visit(
      [&]<class Images>(Images& images) {
        auto next = std::move_iterator(images.begin());
        for (std::size_t i = 0; i < parts.size(); ++i) {
          FrameSet& part = parts[i];
          part.images_ = Images(next, next + counts[i]);
          part.bits_ = frames.bits_;
          part.gain_ = frames.gain_;
          next += counts[i];
        }
      },
      frames.images_);

  return parts;
}

FrameSet joined(std::vector<FrameSet> sets) {
  if (sets.empty()) return {};

  std::visit(
      [&]<class Images>(Images& images) {
        for (FrameSet& set : std::span(sets).subspan(1)) {
          auto* const more = std::get_if<Images>(&set.images_);
          throw_if(more == nullptr, "frames of different formats cannot be joined");
          std::move(more->begin(), more->end(), std::back_inserter(images));
        }

        require_same_size(images);
      },
      sets.front().images_);

  return std::move(sets.front());
}

void MeanFrames::add(const FrameSet& frames) {
  const Image<std::uint8_t> saturated = saturation_mask(frames);

  // The first set determines the format of all.
  if (count_ == 0) {
    bits_ = frames.bits();
    sums_.assign(frames.count(), Image<double>(frames.size()));
    saturated_ = saturated;
  }

  throw_if(frames.count() != static_cast<int>(sums_.size()) || frames.bits() != bits_ ||
               frames.size() != saturated_.size(),
           "scan {} has {} frames of {} with {} bits, the first {} of {} with {}; they must match",
           count_, frames.count(), text_of(frames.size()), frames.bits(), sums_.size(),
           text_of(saturated_.size()), bits_);

  // Sums in 8-bit grey levels.
  const double grey_level = frames.full_scale() / 255;
  frames.visit([&](const auto& views) {
    for (std::size_t n = 0; n < views.size(); ++n) {
      for_each_pixel_in_order(views[n].size(), [&](int column, int row) {
        sums_[n](column, row) += static_cast<double>(views[n](column, row)) / grey_level;
      });
    }
  });

  std::ranges::transform(saturated, saturated_, saturated_.begin(), std::bit_or<>());
  ++count_;
}

FrameSet MeanFrames::mean() const {
  FrameSet::ImagesUnquantised means = sums_;
  for (Image<double>& image : means) {
    for (double& intensity : image) intensity /= count_;
  }

  return FrameSet(std::move(means));
}

void merge_exposures(const FrameViews& frames, const std::vector<double>& exposures,
                     MergedFrames& merged) {
  const std::size_t count = frames.count();
  throw_if(exposures.empty() || exposures.size() > most_exposures || count == 0 ||
               count % exposures.size() != 0,
           "{} frames cannot be split evenly among {} exposures, at most {}", count,
           exposures.size(), most_exposures);

  // Reuse the memory of the last scan.
  const Size size = frames.size();
  merged.images.resize(count / exposures.size());
  for (auto& image : merged.images) {
    if (image.size() != size) image = Image<std::uint16_t>(size);
  }
  if (merged.gain.size() != size) merged.gain = Image<float>(size);

  // In tiles of a row, so that weights stay on the stack.
  frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    if constexpr (std::is_integral_v<Pixel>) {
      const double scale = ((1 << merged_bits) - 1) / frames.full_scale();
      const Merge<Pixel> merge{views, exposures, static_cast<Pixel>(frames.full_scale()),
                               static_cast<float>(scale), merged};

      for_each_row(size.height, [&merge, width = size.width](int row) {
        for (int first = 0; first < width; first += tile) {
          merge(row, first, std::min(tile, width - first));
        }
      });
    } else {
      throw Error("merging exposures requires quantised frames");
    }
  });

  merged.views.assign<std::uint16_t>(merged.images, merged_bits);
  merged.views.set_gain(merged.gain);
}

FrameSet merged_exposures(const FrameViews& frames, const std::vector<double>& exposures) {
  MergedFrames merged;
  merge_exposures(frames, exposures, merged);
  return {std::move(merged.images), merged_bits, std::move(merged.gain)};
}

}  // namespace slipstream
