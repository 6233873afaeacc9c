#include "frames/mosaic.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <regex>
#include <string>
#include <variant>

#include "base/parallel_rows.h"
#include "slipstream/error.h"

namespace slipstream {
namespace {

/// Index of the colour, 0 red to 2 blue, that a pixel's filter passes.
struct Filters {
  explicit Filters(const std::string& mosaic)
      : red_column(mosaic == "GR" || mosaic == "BG" ? 1 : 0),
        red_row(mosaic == "GB" || mosaic == "BG" ? 1 : 0) {}

  [[nodiscard]] std::size_t at(int column, int row) const {
    const bool is_red_column = column % 2 == red_column, is_red_row = row % 2 == red_row;
    if (is_red_column != is_red_row) return 1;
    return is_red_row ? 0 : 2;
  }

  int red_column, red_row;  ///< of the first red pixel
};

}  // namespace

std::string mosaic_named(const std::string& text) {
  std::smatch found;
  const std::regex forms("(RG|GR|GB|BG)|(RG)GB|(GR)BG|(GB)RG|(BG)GR|Bayer(RG|GR|GB|BG)[0-9].*");
  if (!std::regex_match(text, found, forms)) {
    throw Error("`mosaic " + text +
                "`: expected the colours of the first two pixels, RG, GR, GB or BG, or a pixel "
                "format such as BayerRG8");
  }

  // One of the alternatives has matched.
  for (std::size_t i = 1; i < found.size(); ++i) {
    if (found[i].matched) return found[i].str();
  }
  return {};
}

void make_grey(Frame& frame) {
  constexpr std::uint32_t clipped = 1 << 24;  // exceeds any sum of values
  const std::uint32_t full = (1U << frame.bits) - 1;

  std::visit(
      [&]<class Pixel>(Image<Pixel>& image) {
        const Image<Pixel> mosaic = image;
        const int width = image.width(), last = image.height() - 1;
        Image<std::uint32_t> sums(Size{width + 2, 1});  // of three rows, mirrored at the ends

        for (int row = 0; row <= last; ++row) {
          const Pixel* const above = mosaic.row(row > 0 ? row - 1 : std::min(1, last));
          const Pixel* const here = mosaic.row(row);
          const Pixel* const below = mosaic.row(row < last ? row + 1 : std::max(last - 1, 0));

          // Weights 1 2 1 down the columns; a clipped value lifts the sum above any other.
          for (int i = 0; i < width; ++i) {
            const std::uint32_t a = above[i], b = here[i], c = below[i];
            sums(i + 1, 0) = a + 2 * b + c + (std::max({a, b, c}) >= full ? clipped : 0);
          }

          // Weights 1 2 1 along the row: 16 in total, so divide by 16 and round.
          sums(0, 0) = sums(std::min(2, width), 0);
          sums(width + 1, 0) = sums(std::max(width - 1, 1), 0);
          for (int i = 0; i < width; ++i) {
            const std::uint32_t sum = sums(i, 0) + 2 * sums(i + 1, 0) + sums(i + 2, 0);
            image(i, row) = static_cast<Pixel>(sum >= clipped ? full : (sum + 8) / 16);
          }
        }
      },
      frame.pixels);
}

template <class Pixel>
Image<Pixel> demosaiced(const Image<Pixel>& raw, const std::string& mosaic) {
  const Filters filters(mosaic);
  const int width = raw.width(), height = raw.height();
  Image<Pixel> rgb({3 * width, height}, uninitialised);

  for_each_pixel(raw.size(), [&](int column, int row) {
    // 1. Sums over the neighbours of each colour: all of another colour are equally far away.
    std::array<std::uint32_t, 3> sums{}, counts{};
    for (int y = std::max(row - 1, 0); y <= std::min(row + 1, height - 1); ++y) {
      for (int x = std::max(column - 1, 0); x <= std::min(column + 1, width - 1); ++x) {
        const std::size_t colour = filters.at(x, y);
        sums[colour] += raw(x, y);
        ++counts[colour];
      }
    }

    // 2. The pixel's own colour is known.
    const std::size_t own = filters.at(column, row);
    sums[own] = raw(column, row);
    counts[own] = 1;

    // 3. Their means, rounded. A picture of one row or column lacks a colour.
    Pixel* const to = rgb.row(row) + 3 * column;
    for (std::size_t colour = 0; colour < 3; ++colour) {
      const std::uint32_t count = std::max(counts[colour], 1U);
      to[colour] = static_cast<Pixel>((sums[colour] + count / 2) / count);
    }
  });

  return rgb;
}

template Image<std::uint8_t> demosaiced(const Image<std::uint8_t>&, const std::string&);
template Image<std::uint16_t> demosaiced(const Image<std::uint16_t>&, const std::string&);

}  // namespace slipstream
