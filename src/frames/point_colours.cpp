#include "frames/point_colours.h"

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <mutex>

#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"

namespace slipstream {

template <class Pixel>
void ColourMean::add(const Image<Pixel>& rgb) {
  const std::lock_guard lock(mutex_);
  if (count_ == 0) sums_ = Image<std::uint32_t>(rgb.size());
  if (rgb.size() != sums_.size()) return;

  for (std::size_t i = 0; i < rgb.pixel_count(); ++i) sums_.begin()[i] += rgb.begin()[i];
  ++count_;
}

template void ColourMean::add(const Image<std::uint8_t>&);
template void ColourMean::add(const Image<std::uint16_t>&);

Image<ColourLevels> ColourMean::levels(double full_scale) const {
  if (count_ == 0) return {};

  const auto factor = static_cast<float>(255 / (full_scale * count_));
  Image<ColourLevels> levels({sums_.width() / 3, sums_.height()});
  bool any_colour = false;

  const std::uint32_t* sum = sums_.begin();
  for (ColourLevels& pixel : levels) {
    any_colour |= sum[0] != sum[1] || sum[1] != sum[2];
    for (float& level : pixel) level = factor * static_cast<float>(*sum++);
  }

  if (!any_colour) return {};
  return levels;
}

Image<ColourLevels> colour_levels(const FrameViews& channels) {
  const auto factor = static_cast<float>(255 / channels.full_scale());
  Image<ColourLevels> levels(channels.size());

  channels.visit([&](const auto& views) {
    for_each_pixel(levels.size(), [&](int column, int row) {
      for (std::size_t c = 0; c < 3; ++c) {
        levels(column, row)[c] = factor * static_cast<float>(views[c](column, row));
      }
    });
  });
  return levels;
}

WhiteBalance white_balance(const Image<ColourLevels>& levels, const Rectangle& grey_patch) {
  constexpr double darkest = 8, brightest = 250;  // grey levels

  // 1. The patch lies in the picture.
  const auto& [left, top, size] = grey_patch;
  throw_if(left < 0 || top < 0 || size.width < 1 || size.height < 1 ||
               size.width > levels.width() - left || size.height > levels.height() - top,
           "`grey_patch`: {}+{}+{} is not inside the picture, {}", text_of(size), left, top,
           text_of(levels.size()));

  // 2. Its mean colour.
  WhiteBalance mean{};
  for (int row = top; row < top + size.height; ++row) {
    for (int column = left; column < left + size.width; ++column) {
      for (std::size_t c = 0; c < 3; ++c) mean[c] += double{levels(column, row)[c]};
    }
  }
  for (double& level : mean) level /= static_cast<double>(size.width) * size.height;

  const auto [least, most] = std::ranges::minmax(mean);
  throw_if(
      !(least >= darkest && most <= brightest),
      "`grey_patch`: its red, green and blue are {:.0f}, {:.0f} and {:.0f}; a patch of grey or "
      "white between {:g} and {:g} is needed",
      mean[0], mean[1], mean[2], darkest, brightest);

  // 3. The brightest colour stays, so that white does not become coloured where it is clipped.
  WhiteBalance balance{};
  for (std::size_t c = 0; c < 3; ++c) balance[c] = most / mean[c];
  return balance;
}

Image<Colour> balanced(const Image<ColourLevels>& levels, const WhiteBalance& balance) {
  Image<Colour> colours(levels.size(), uninitialised);
  for_each_pixel(levels.size(), [&](int column, int row) {
    const ColourLevels& of = levels(column, row);
    const auto in_8_bits = [&](std::size_t c) {
      return static_cast<std::uint8_t>(std::clamp(double{of[c]} * balance[c], 0.0, 255.0) + 0.5);
    };
    colours(column, row) = {in_8_bits(0), in_8_bits(1), in_8_bits(2)};
  });
  return colours;
}

}  // namespace slipstream
