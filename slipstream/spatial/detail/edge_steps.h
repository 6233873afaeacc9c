#pragma once

#include <cstdint>

#include "slipstream/spatial/detail/methods.h"

namespace slipstream {

/// The whole periods by which the order changes between neighbours, of phases in [-0.5, 0.5], that
/// lie less than half a period apart.
inline int step_between(float from, float to) {
  return (from - to > 0.5F ? 1 : 0) - (from - to < -0.5F ? 1 : 0);
}

/// By how many periods the order changes from each pixel to its right and to its lower neighbour.
struct EdgeSteps {
  static constexpr std::int16_t closed = -32768;  ///< there is no way, or no neighbour

  Image<std::int16_t> right, down;

  [[nodiscard]] Size size() const { return right.size(); }

  /// Calls `visit(to, step)` for each neighbour that an edge leads to.
  template <class Visit>
  void for_each_neighbour(int at, const Visit& visit) const {
    // An edge to the left or above that is not there is closed: the pixel before is a row's last.
    const int width = size().width;
    const std::int16_t* const to_right = right.begin();
    const std::int16_t* const to_below = down.begin();
    if (to_right[at] != closed) visit(at + 1, to_right[at]);
    if (to_below[at] != closed) visit(at + width, to_below[at]);
    if (at >= 1 && to_right[at - 1] != closed) visit(at - 1, -to_right[at - 1]);
    if (at >= width && to_below[at - width] != closed) visit(at - width, -to_below[at - width]);
  }
  /// The edge between two neighbours, of which `at` is the left or the upper one.
  std::int16_t& edge(int at, int to) {
    return to - at == size().width ? down.begin()[at] : right.begin()[at];
  }
};
EdgeSteps edge_steps(const Image<float>& cycles);

/// What a whole turn around each corner of pixels changes, closed edges nothing; pixel (x, y) is
/// the lower right one of corner (x, y), and there is a column and a row more of these than of
/// pixels.
Image<int> charges_of(const EdgeSteps& steps);

/// From pixel to pixel along the steps; what they connect is a region.
Orders flood(const WrappedCycles& wrapped, const EdgeSteps& steps);

}  // namespace slipstream
