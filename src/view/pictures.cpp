#include "view/pictures.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <type_traits>

#include "view/scene_renderer.h"

namespace slipstream::view {
namespace {

constexpr Colour saturated_colour{235, 40, 40};
constexpr Colour nothing{26, 28, 33};

/// Reduction factor per direction.
int reduction(Size size, int widest) {
  return std::max(1, (size.width + widest / 2) / std::max(widest, 1));
}

/// A reduced picture of `colour_of(column, row)` at the upper left pixel of each block.
template <class ColourOf>
Image<Colour> picture_of(Size size, int widest, const ColourOf& colour_of) {
  if (size.width < 1 || size.height < 1) return {};

  const int step = reduction(size, widest);
  Image<Colour> picture({std::max(1, size.width / step), std::max(1, size.height / step)});

  for_each_pixel_in_order(picture.size(), [&](int column, int row) {
    picture(column, row) = colour_of(column * step, row * step);
  });

  return picture;
}

Colour grey(double level) {
  const auto part = static_cast<std::uint8_t>(std::clamp(std::lround(level), 0L, 255L));
  return {part, part, part};
}

Colour bluish(const Colour& grey) {
  return {static_cast<std::uint8_t>(grey.red / 2), static_cast<std::uint8_t>(grey.green / 2 + 24),
          static_cast<std::uint8_t>(grey.blue / 2 + 96)};
}

template <class Pixel>
void mark_saturated(Image<Colour>& picture, const ImageView<const Pixel>& frame, Pixel full_scale,
                    int step) {
  const Size shown{std::min(frame.width(), picture.width() * step),
                   std::min(frame.height(), picture.height() * step)};

  for_each_pixel_in_order(shown, [&](int column, int row) {
    if (frame(column, row) >= full_scale) picture(column / step, row / step) = saturated_colour;
  });
}

}  // namespace

Image<Colour> camera_picture(const FrameViews& frames, int widest,
                             const Image<Validity>* validity) {
  if (frames.count() == 0) return {};

  const double full_scale = frames.full_scale();
  return frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    Image<Colour> picture = picture_of(frames.size(), widest, [&](int column, int row) {
      const Colour level = grey(255 * views.front()(column, row) / full_scale);
      const bool dark = validity != nullptr && (*validity)(column, row) == Validity::too_dark;
      return dark ? bluish(level) : level;
    });

    // Unquantised frames do not saturate.
    if constexpr (std::is_integral_v<Pixel>) {
      // From every pixel, since a reduced picture could miss single ones.
      for (const auto& view : views) {
        mark_saturated(picture, view, static_cast<Pixel>(frames.saturation()),
                       reduction(frames.size(), widest));
      }
    }

    return picture;
  });
}

GreyHistogram grey_histogram(const FrameViews& frames) {
  GreyHistogram histogram{};
  constexpr int every = 7;  // samples every Nth pixel in each direction
  const double bins_per_level = static_cast<double>(histogram.size()) / (frames.full_scale() + 1);

  frames.visit([&](const auto& views) {
    for (const auto& view : views) {
      for (int row = 0; row < view.height(); row += every) {
        for (int column = 0; column < view.width(); column += every) {
          const double bin = std::max(bins_per_level * view(column, row), 0.0);
          ++histogram[std::min(static_cast<std::size_t>(bin), histogram.size() - 1)];
        }
      }
    }
  });

  // Square roots, so that rare levels remain visible.
  const float most = std::max(*std::max_element(histogram.begin(), histogram.end()), 1.0F);
  for (float& count : histogram) count = std::sqrt(count / most);

  return histogram;
}

Image<Colour> modulation_picture(const Image<float>& modulation, int widest) {
  const float white = std::max(robust_range(modulation).high, 1e-3F);
  return picture_of(modulation.size(), widest, [&](int column, int row) {
    return grey(255.0 * static_cast<double>(modulation(column, row) / white));
  });
}

Image<Colour> phase_picture(const Image<float>& phase, const Image<float>& modulation, float least,
                            int widest) {
  const ColourMap hues = phase_colours();
  return picture_of(phase.size(), widest, [&](int column, int row) {
    const float turn = phase(column, row) / (2 * std::numbers::pi_v<float>);
    if (!(modulation(column, row) >= least) || !std::isfinite(turn)) return nothing;

    const float share = turn - std::floor(turn);
    return hues[std::min<std::size_t>(static_cast<std::size_t>(share * 256), 255)];
  });
}

}  // namespace slipstream::view
