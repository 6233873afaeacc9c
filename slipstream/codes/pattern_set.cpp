#include "slipstream/codes/pattern_set.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/one_bit.h"

namespace slipstream {
namespace {

/// The intensities of pattern n at the pixels' centres, along the rows whatever its axis.
Image<double> levels_along_rows(const PatternSet& patterns, int n, Size size) {
  Image<double> levels(size);
  for (int row = 0; row < size.height; ++row) {
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

void require_valid(const PatternLight& light) {
  const bool in_range =
      light.alpha_p > 0 && light.beta_p >= 0 && light.alpha_p + light.beta_p <= 255;
  if (!in_range) {
    throw Error(fmt::format(
        "alpha_p {} and beta_p {} are out of range; alpha_p > 0, beta_p >= 0 and their sum <= 255",
        light.alpha_p, light.beta_p));
  }
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
  if (projector.width < 1 || projector.height < 1) {
    throw Error(fmt::format("projector size {}x{} is empty; give its width and height in pixels",
                            projector.width, projector.height));
  }
  if (n < 0 || n >= patterns.count) {
    throw Error(fmt::format("pattern {} does not exist; the set has {}", n, patterns.count));
  }
  if (bits < 8 || bits > 16) {
    throw Error(fmt::format("{} bits per projector pixel are out of range; 8 to 16", bits));
  }

  const double scale = ((1 << bits) - 1) / 255.0;
  const bool along_rows = patterns.axis_of(n) == Axis::x;
  Image<double> levels = levels_along_rows(
      patterns, n, along_rows ? projector : Size{projector.height, projector.width});
  if (patterns.binary) levels = one_bit(std::move(levels));
  Image<std::uint16_t> picture(projector);
  for (int row = 0; row < projector.height; ++row) {
    for (int column = 0; column < projector.width; ++column) {
      const double level = along_rows ? levels(column, row) : levels(row, column);
      picture(column, row) = static_cast<std::uint16_t>(std::lround(scale * level));
    }
  }
  return picture;
}

}  // namespace slipstream
