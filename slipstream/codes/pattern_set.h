#pragma once

#include <concepts>
#include <cstddef>
#include <functional>
#include <utility>
#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/codes/axis.h"

namespace slipstream {

/// The light of a projector's patterns, in grey levels of an 8-bit projector: I^p = alpha_p s +
/// beta_p with s in [0, 1] (Liu 2010, Eq. 3.1). A projector of m bits scales both by
/// (2^m - 1) / 255.
struct PatternLight {
  double alpha_p = 255;  ///< amplitude constant, > 0
  double beta_p = 0;     ///< balance constant against underflow, >= 0; alpha_p + beta_p <= 255

  friend bool operator==(const PatternLight&, const PatternLight&) = default;
};

/// Throws Error when alpha_p, beta_p are not in the ranges above.
void require_valid(const PatternLight& light);

/// s of pattern n at projector coordinate y in [0, 1) along its axis and, where a carrier runs
/// across it, at `across`, the coordinate along the other one. Made of functions of n and y too.
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

/// What a projector shows in one scan: `count` patterns, each a function of the projector
/// coordinate along an axis, or of both coordinates.
struct PatternSet {
  int count = 0;
  Axis axis = Axis::x;  ///< of the first
  PatternLight light;
  PatternShape shape;  ///< s: see PatternLight
  /// How long the camera looks at each pattern, relative to its usual exposure; 1 where not said.
  std::vector<double> exposures{};
  /// Shown by pixels that are dark (0) or bright (255) alone, whose mean is the intensity: for a
  /// DMD that shows a bit at a time.
  bool binary = false;

  int turn = 0;  ///< so many along the one axis, so many along the other, and so on; 0: all alike
  bool carrier = false;  ///< whether the shape varies across the axis too

  [[nodiscard]] Axis axis_of(int n) const {
    return turn > 0 && n / turn % 2 == 1 ? across(axis) : axis;
  }
  [[nodiscard]] double exposure(int n) const {
    const auto index = static_cast<std::size_t>(n);
    return index < exposures.size() ? exposures[index] : 1;
  }
  /// I_n^p in grey levels of an 8-bit projector, not quantised.
  [[nodiscard]] double intensity(int n, double y, double across = 0) const {
    return light.alpha_p * shape(n, y, across) + light.beta_p;
  }
};

/// Pattern n of the set alone, exposed as it was there.
PatternSet pattern_alone(const PatternSet& patterns, int n);

/// The set with one more pattern after the last, dark (`shape` 0) or bright (1) all over: when the
/// set is shown again and again it marks where a cycle ends.
PatternSet with_marker(PatternSet patterns, double shape = 0);

/// Pattern n as the picture to send to a projector of that size, rounded to the nearest grey level
/// of `bits` (8 to 16). The value of a pixel is the intensity at its centre; of a binary set it is
/// 0 or full scale: see one_bit. Throws Error when the projector has no pixels, n is not in the set
/// or bits are out of range.
Image<std::uint16_t> render_pattern(const PatternSet& patterns, int n, Size projector,
                                    int bits = 8);

}  // namespace slipstream
