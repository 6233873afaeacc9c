#pragma once

#include <array>
#include <concepts>
#include <cstdint>
#include <functional>
#include <string_view>
#include <vector>

#include "slipstream/image.h"

namespace slipstream {

/// The projector axis along which a pattern varies: `x`, from column to column (vertical stripes);
/// `y`, from row to row, as in Liu 2010.
enum class Axis { x, y };

/// Projector pixels along the axis: the width for `x`, the height for `y`.
constexpr int length_along(Axis axis, Size projector) {
  return axis == Axis::x ? projector.width : projector.height;
}

/// The other axis.
constexpr Axis across(Axis axis) {
  return axis == Axis::x ? Axis::y : Axis::x;
}

/// "x" or "y".
constexpr std::string_view name_of(Axis axis) {
  return axis == Axis::x ? "x" : "y";
}

/// Parses "x" or "y". Throws Error for any other name.
Axis axis_named(std::string_view name);

/// Projector coordinate, [0, 1) across the field, of a pixel's centre: index / projector_length.
constexpr double coordinate_of_pixel(int index, int projector_length) {
  return static_cast<double>(index) / projector_length;
}

/// The light of a projector's patterns, in grey levels of an 8-bit projector: I^p = alpha_p s +
/// beta_p with s in [0, 1] (Liu 2010, Eq. 3.1). A projector with m bits scales both by (2^m - 1) /
/// 255.
struct PatternLight {
  double alpha_p = 255;  ///< amplitude constant, > 0
  double beta_p = 0;     ///< offset against underflow, >= 0; alpha_p + beta_p <= 255

  friend bool operator==(const PatternLight&, const PatternLight&) = default;
};

/// Throws Error if alpha_p or beta_p is out of range.
void require_valid(const PatternLight& light);

/// s of pattern n at projector coordinate y in [0, 1) along its axis and, with a carrier, at
/// `across`, the coordinate along the other axis. Also constructible from functions of n and y.
class PatternShape {
 public:
  PatternShape() = default;

  template <std::invocable<int, double> Along>
  PatternShape(Along along)  // NOLINT(google-explicit-constructor)
      : shape_([along = std::move(along)](int n, double y, double) { return along(n, y); }) {}

  template <std::invocable<int, double, double> OverField>
  PatternShape(OverField over_field)  // NOLINT(google-explicit-constructor)
      : shape_(std::move(over_field)) {}

  double operator()(int n, double y, double across) const { return shape_(n, y, across); }

 private:
  std::function<double(int n, double y, double across)> shape_;
};

/// The patterns of one scan: `count` functions of one or both coordinates.
struct PatternSet {
  int count = 0;
  Axis axis = Axis::x;  ///< of the first pattern
  PatternLight light;
  PatternShape shape;  ///< s: see PatternLight
  /// Camera exposure of each pattern, relative to its usual one; default 1.
  std::vector<double> exposures{};
  /// Patterns are dithered to dark (0) or bright (255) pixels whose mean is the intensity, for
  /// 1-bit DMDs.
  bool binary = false;

  int turn = 0;          ///< patterns along `axis`, before those across it; 0: all
  int along_other = 0;   ///< patterns across it; 0: as many as along it
  bool carrier = false;  ///< whether the shape also varies across the axis

  [[nodiscard]] Axis axis_of(int n) const {
    const int both = turn + (along_other > 0 ? along_other : turn);
    return turn > 0 && n % both >= turn ? across(axis) : axis;
  }

  [[nodiscard]] double exposure(int n) const {
    return std::cmp_less(n, exposures.size()) ? exposures[n] : 1;
  }

  /// I_n^p in grey levels of an 8-bit projector, not quantised.
  [[nodiscard]] double intensity(int n, double y, double across = 0) const {
    return light.alpha_p * shape(n, y, across) + light.beta_p;
  }
};

/// Pattern n of the set alone, with its exposure.
PatternSet pattern_alone(const PatternSet& patterns, int n);

/// Appends a uniform pattern, dark (`shape` 0) or bright (1), which marks the end of a cycle.
PatternSet with_marker(PatternSet patterns, double shape = 0);

/// Pattern n as an image for that projector: intensities at pixel centres, rounded to grey levels
/// of `bits` (8 to 16); 0 or full scale for a binary set, see one_bit. Throws Error if the
/// projector has no pixels, n is not in the set or `bits` is out of range.
Image<std::uint16_t> render_pattern(const PatternSet& patterns, int n, Size projector,
                                    int bits = 8);

/// Dithers an image of 8-bit grey levels to 0 and 255 by error diffusion. Once blurred, it is most
/// accurate where the image varies along its rows.
Image<double> one_bit(Image<double> picture);

/// Converts a pattern rendered with 8 bits to 8-bit pixels.
Image<std::uint8_t> in_8_bits(const Image<std::uint16_t>& pattern);

/// All patterns of a set, rendered to 8 bits.
std::vector<Image<std::uint8_t>> patterns_in_8_bits(const PatternSet& set, Size projector);

/// Three patterns, from `first` on, as red, green and blue of one image.
Image<Colour> picture_in_colour(const PatternSet& set, int first, Size projector);

/// Uniform images for measuring a colour projector's ColourMixture, by name.
inline constexpr std::array primary_names{"black", "red", "green", "blue"};

/// Half the projector's light in all colours, the average of patterns: distinguishes paint from
/// pattern.
inline PatternSet white_pattern(const PatternLight& light) {
  return {.count = 3, .light = light, .shape = [](int, double) { return 0.5; }};
}

/// The images of `primary_names` as three patterns each, one per channel.
inline PatternSet primary_patterns(const PatternLight& light) {
  constexpr int channels = 3;
  return {.count = channels * static_cast<int>(primary_names.size()),
          .light = light,
          .shape = [](int n, double) { return n / channels == n % channels + 1 ? 1.0 : 0.0; }};
}

}  // namespace slipstream
