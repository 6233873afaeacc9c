#include "slipstream/frames/merged_exposures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"

namespace slipstream {
namespace {

/// Of no exposure's share is a merged level larger than sqrt(16) full scales: these bits, in 16.
constexpr int merged_bits = 14;
constexpr std::size_t most_exposures = 16;
/// Pixels that are merged at a time, so that their weights need no memory of their own.
constexpr int tile = 128;
using TileRow = std::array<float, tile>;

template <class Pixel>
struct Merge {
  const Frames<Pixel>& frames;
  const std::vector<double>& exposures;
  Pixel full;
  float scale;  ///< merged grey levels for each of the frames
  MergedFrames& merged;

  [[nodiscard]] std::size_t count() const { return frames.size() / exposures.size(); }
  [[nodiscard]] std::size_t shortest() const {
    return static_cast<std::size_t>(std::min_element(exposures.begin(), exposures.end()) -
                                    exposures.begin());
  }
  [[nodiscard]] const Pixel* levels(std::size_t e, std::size_t n, int row, int first) const {
    return frames[e * count() + n].row(row) + first;
  }

  /// t_e where exposure e has no saturated frame, else 0.
  void weigh(std::size_t e, int row, int first, int width, TileRow& weights) const {
    std::array<Pixel, tile> greatest{};
    for (std::size_t n = 0; n < count(); ++n) {
      const Pixel* const I = levels(e, n, row, first);
      for (int i = 0; i < width; ++i) greatest[i] = std::max(greatest[i], I[i]);
    }
    const auto t = static_cast<float>(exposures[e]);
    for (int i = 0; i < width; ++i) weights[i] = greatest[i] < full ? t : 0;
  }

  void merge(int row, int first, int width) const {
    std::array<TileRow, most_exposures> weights;
    TileRow squares{};
    for (std::size_t e = 0; e < exposures.size(); ++e) {
      weigh(e, row, first, width, weights[e]);
      for (int i = 0; i < width; ++i) squares[i] += weights[e][i] * weights[e][i];
    }
    const auto least = static_cast<float>(exposures[shortest()]);
    TileRow saturated{};
    for (int i = 0; i < width; ++i) {
      saturated[i] = squares[i] == 0 ? 1 : 0;
      weights[shortest()][i] += saturated[i] * least;
      squares[i] += saturated[i] * least * least;
    }
    float* const gain = merged.gain.row(row) + first;
    TileRow norms;
    for (int i = 0; i < width; ++i) {
      gain[i] = std::sqrt(squares[i]) / least;
      norms[i] = scale / std::sqrt(squares[i]);
    }
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

  void operator()(int row) const {
    const int width = frames.front().width();
    for (int first = 0; first < width; first += tile) {
      merge(row, first, std::min(tile, width - first));
    }
  }
};

void prepare(MergedFrames& merged, std::size_t count, Size size) {
  merged.images.resize(count);
  for (auto& image : merged.images) {
    if (image.size() != size) image = Image<std::uint16_t>(size);
  }
  if (merged.gain.size() != size) merged.gain = Image<float>(size);
}

}  // namespace

void merge_exposures(const FrameViews& frames, const std::vector<double>& exposures,
                     MergedFrames& merged) {
  const auto given = static_cast<std::size_t>(frames.count());
  if (exposures.empty() || exposures.size() > most_exposures || given == 0 ||
      given % exposures.size() != 0) {
    throw Error(fmt::format("{} frames are not as many for each of {} exposures, at most {}", given,
                            exposures.size(), most_exposures));
  }
  prepare(merged, given / exposures.size(), frames.size());
  frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    if constexpr (std::is_integral_v<Pixel>) {
      const double scale = ((1 << merged_bits) - 1) / frames.full_scale();
      const Merge<Pixel> merge{views, exposures, static_cast<Pixel>(frames.full_scale()),
                               static_cast<float>(scale), merged};
      for_each_row(frames.size().height, [&merge](int row) { merge(row); });
    } else {
      throw Error("frames that are not quantised are of one exposure: nothing saturates them");
    }
  });
  merged.views.assign<std::uint16_t>(
      merged.images, merged_bits,
      [](const Image<std::uint16_t>& image) { return ImageView<const std::uint16_t>(image); });
  merged.views.set_gain(merged.gain);
}

FrameSet merged_exposures(const FrameViews& frames, const std::vector<double>& exposures) {
  MergedFrames merged;
  merge_exposures(frames, exposures, merged);
  return {std::move(merged.images), merged_bits, std::move(merged.gain)};
}

}  // namespace slipstream
