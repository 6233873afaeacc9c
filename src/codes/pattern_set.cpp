#include "slipstream/pattern_set.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <string_view>

#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

/// Intensities of pattern n at the pixel centres, along the rows whatever its axis.
Image<double> levels_along_rows(const PatternSet& patterns, int n, Size size) {
  Image<double> levels(size);

  for (int row = 0; row < size.height; ++row) {
    // Without a carrier all rows are equal.
    if (row > 0 && !patterns.carrier) {
      std::copy(levels.row(0), levels.row(1), levels.row(row));
      continue;
    }

    const double across = coordinate_of_pixel(row, size.height);
    for (int column = 0; column < size.width; ++column) {
      levels(column, row) = patterns.intensity(n, coordinate_of_pixel(column, size.width), across);
    }
  }

  return levels;
}

}  // namespace

Axis axis_named(std::string_view name) {
  if (name == "x") return Axis::x;
  if (name == "y") return Axis::y;
  throw Error("axis '" + std::string(name) + "' is unknown; expected x or y");
}

void require_valid(const PatternLight& light) {
  const auto& [alpha_p, beta_p] = light;
  throw_if(
      !(alpha_p > 0 && beta_p >= 0 && alpha_p + beta_p <= 255),
      "alpha_p {} and beta_p {} are out of range; alpha_p > 0, beta_p >= 0 and their sum <= 255",
      alpha_p, beta_p);
}

PatternSet pattern_alone(const PatternSet& patterns, int n) {
  PatternSet alone = patterns;
  alone.count = 1;
  alone.axis = patterns.axis_of(n);
  alone.turn = 0;
  alone.shape = [shape = patterns.shape, n](int, double y, double across) {
    return shape(n, y, across);
  };
  alone.exposures = {patterns.exposure(n)};

  return alone;
}

PatternSet with_marker(PatternSet patterns, double shape) {
  const int marker = patterns.count++;
  patterns.shape = [patterned = patterns.shape, marker, shape](int n, double y, double across) {
    return n == marker ? shape : patterned(n, y, across);
  };
  return patterns;
}

Image<std::uint16_t> render_pattern(const PatternSet& patterns, int n, Size projector, int bits) {
  throw_if(projector.width < 1 || projector.height < 1,
           "projector size {}x{} is out of range; at least 1x1 pixels", projector.width,
           projector.height);
  throw_if(n < 0 || n >= patterns.count, "pattern {} does not exist; the set has {}", n,
           patterns.count);
  throw_if(bits < 8 || bits > 16, "{} bits per projector pixel are out of range; 8 to 16", bits);

  const double scale = ((1 << bits) - 1) / 255.0;
  // Made along rows whatever the axis, because dithering is most accurate there, then turned.
  const bool along_rows = patterns.axis_of(n) == Axis::x;
  Image<double> levels = levels_along_rows(
      patterns, n, along_rows ? projector : Size{projector.height, projector.width});
  if (patterns.binary) levels = one_bit(std::move(levels));

  Image<std::uint16_t> picture(projector);
  for_each_pixel_in_order(projector, [&](int column, int row) {
    const double level = along_rows ? levels(column, row) : levels(row, column);
    picture(column, row) = static_cast<std::uint16_t>(std::lround(scale * level));
  });

  return picture;
}

Image<double> one_bit(Image<double> picture) {
  // Not one half: a pattern and its inverse, which N-step patterns of an even N contain, would have
  // equal errors, which would add up in the phase.
  constexpr double bright = 255, threshold = 0.6 * bright;

  // Shares of the error, optimised for the phase of 3, 4 and 6 steps with periods of 16 to 75
  // pixels, blurred by Gaussians of 1 to 3 pixels.
  constexpr double ahead = 0.45, below_behind = 0.35, below = 0.2;

  // Errors that leave the picture are lost.
  const auto add = [&](int column, int row, double error) {
    const bool inside = column >= 0 && column < picture.width() && row < picture.height();
    if (inside) picture(column, row) += error;
  };

  for (int row = 0; row < picture.height(); ++row) {
    // Alternate directions: otherwise the stripes would drift to one side.
    const int forward = row % 2 == 0 ? 1 : -1;
    for (int i = 0; i < picture.width(); ++i) {
      const int column = forward > 0 ? i : picture.width() - 1 - i;
      double& level = picture(column, row);
      const double shown = level > threshold ? bright : 0, error = level - shown;
      level = shown;

      // The error goes ahead in this row and to two pixels of the next one.
      add(column + forward, row, ahead * error);
      add(column - forward, row + 1, below_behind * error);
      add(column, row + 1, below * error);
    }
  }

  return picture;
}

Image<std::uint8_t> in_8_bits(const Image<std::uint16_t>& pattern) {
  Image<std::uint8_t> narrow(pattern.size());
  std::ranges::copy(pattern, narrow.begin());
  return narrow;
}

std::vector<Image<std::uint8_t>> patterns_in_8_bits(const PatternSet& set, Size projector) {
  std::vector<Image<std::uint8_t>> patterns;
  for (int n = 0; n < set.count; ++n)
    patterns.push_back(in_8_bits(render_pattern(set, n, projector)));
  return patterns;
}

Image<Colour> picture_in_colour(const PatternSet& set, int first, Size projector) {
  const Image<std::uint16_t> red = render_pattern(set, first % set.count, projector),
                             green = render_pattern(set, (first + 1) % set.count, projector),
                             blue = render_pattern(set, (first + 2) % set.count, projector);

  Image<Colour> picture(projector);
  for (std::size_t i = 0; i < picture.pixel_count(); ++i) {
    const auto level = [&](const Image<std::uint16_t>& pattern) {
      return static_cast<std::uint8_t>(pattern.begin()[i]);
    };
    picture.begin()[i] = {level(red), level(green), level(blue)};
  }

  return picture;
}

}  // namespace slipstream
