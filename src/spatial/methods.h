#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "slipstream/image.h"

namespace slipstream {

/// A wrapped phase map, the input of the methods.
struct WrappedCycles {
  Image<float> cycles;  ///< phase in periods, [-0.5, 0.5]; NaN if missing
  /// Above 0, higher is better; an empty image means unknown.
  Image<float> quality;

  [[nodiscard]] bool has(std::size_t pixel) const {
    return cycles.begin()[pixel] == cycles.begin()[pixel];
  }
};

/// Result of the methods.
struct Orders {
  Image<int> order;   ///< whole periods to add
  Image<int> region;  ///< equal for connected pixels; -1 without a phase
};

/// Change of the order between neighbours with phases in [-0.5, 0.5], assuming that the true phases
/// differ by less than half a period.
inline int step_between(float from, float to) {
  return (from - to > 0.5F ? 1 : 0) - (from - to < -0.5F ? 1 : 0);
}

/// Change of the order, in periods, from each pixel to its right and lower neighbours.
struct EdgeSteps {
  static constexpr std::int16_t closed = -32768;  ///< no connection, or no neighbour

  Image<std::int16_t> right, down;

  [[nodiscard]] Size size() const { return right.size(); }

  /// Calls `visit(to, step)` for each connected neighbour.
  template <class Visit>
  void for_each_neighbour(int at, const Visit& visit) const {
    // At the left end the edge is closed: the pixel before is the last of its row.
    const int width = size().width;
    const std::int16_t* const to_right = right.begin();
    const std::int16_t* const to_below = down.begin();

    if (to_right[at] != closed) visit(at + 1, to_right[at]);
    if (to_below[at] != closed) visit(at + width, to_below[at]);
    if (at >= 1 && to_right[at - 1] != closed) visit(at - 1, -to_right[at - 1]);
    if (at >= width && to_below[at - width] != closed) visit(at - width, -to_below[at - width]);
  }

  /// Calls `visit(at, to, step)` for each edge, edges to the right first.
  template <class Visit>
  void for_each_edge(const Visit& visit) const {
    for (const auto& [edges, apart] : {std::pair(&right, 1), std::pair(&down, size().width)}) {
      for (int at = 0; at < static_cast<int>(edges->pixel_count()); ++at) {
        if (edges->begin()[at] != closed) visit(at, at + apart, edges->begin()[at]);
      }
    }
  }

  /// The edge between two neighbours; `at` is the left or upper one.
  std::int16_t& edge(int at, int to) {
    return to - at == size().width ? down.begin()[at] : right.begin()[at];
  }
};

EdgeSteps edge_steps(const Image<float>& cycles);

/// Residue at each corner: sum of the steps around it, closed edges counting 0. Pixel (x, y) lies
/// to the lower right of corner (x, y), so there is one more row and column of corners.
Image<int> charges_of(const EdgeSteps& steps);

/// Integrates the steps from pixel to pixel; connected pixels form a region.
Orders flood(const WrappedCycles& wrapped, const EdgeSteps& steps);

/// Unreliability of each pixel's phase: its squared distance, in periods, from the mean of two
/// opposite neighbours, averaged over row, column and diagonals, divided by the squared quality, if
/// known.
Image<float> roughness(const WrappedCycles& wrapped);

/// The weight of each pixel, 0 to 1: decreases with its roughness relative to most.
Image<float> smoothness(const WrappedCycles& wrapped);

/// Cost in `flow` of the first change of the step between two pixels by `change`, 1 or -1: the
/// growth of the squared difference times the smoothness, so that steps of nearly half a period
/// change first.
inline int cost_of_change(const WrappedCycles& wrapped, const Image<float>& smoothness, int from,
                          int to, int change) {
  const float first = wrapped.cycles.begin()[from], second = wrapped.cycles.begin()[to];
  const float rest = second - first + static_cast<float>(step_between(first, second));
  // Costs are whole numbers: hundredths of a squared period.
  const float weight = 100 * std::min(smoothness.begin()[from], smoothness.begin()[to]);
  return 1 + static_cast<int>(weight * (1 + 2 * static_cast<float>(change) * rest));
}

/// Groups of pixels with known relative orders, initially one pixel each: a union-find whose
/// members store their order relative to their parent.
class PhaseGroups {
 public:
  explicit PhaseGroups(std::size_t pixels) : members_(pixels) {}

  struct Place {
    int group = 0;
    int order = 0;  ///< relative to the group's root
  };
  Place find(int pixel) {
    int order = 0;

    while (true) {
      Member& member = members_[pixel];
      if (member.before < 0) return {pixel, order};

      const Member before = members_[member.before];
      if (before.before < 0) return {member.before, order + member.order};

      member = {before.before, member.order + before.order};  // path halving
      order += member.order;
      pixel = member.before;
    }
  }

  /// Joins two groups, with `step` periods from one pixel to the other.
  void join(int from, int to, int step) {
    Place first = find(from), second = find(to);
    if (first.group == second.group) return;

    // The step from root to root; the larger group keeps its root.
    step += first.order - second.order;
    if (members_[first.group].before > members_[second.group].before) {
      std::swap(first, second);
      step = -step;
    }

    members_[first.group].before += members_[second.group].before;
    members_[second.group] = {first.group, step};
  }

  Orders orders(const WrappedCycles& wrapped) {
    Orders orders{Image<int>(wrapped.cycles.size()), Image<int>(wrapped.cycles.size(), -1)};

    for (std::size_t i = 0; i < members_.size(); ++i) {
      if (!wrapped.has(i)) continue;

      const Place place = find(static_cast<int>(i));
      orders.region.begin()[i] = place.group;
      orders.order.begin()[i] = place.order;
    }

    return orders;
  }

 private:
  struct Member {
    int before = -1;  ///< parent; for a root, the negative size of its group
    int order = 0;    ///< relative to the parent
  };

  std::vector<Member> members_;
};

// The methods.
Orders orders_by_rows(const WrappedCycles& wrapped);
Orders orders_by_flood(const WrappedCycles& wrapped);
Orders orders_by_regions(const WrappedCycles& wrapped);
Orders orders_by_quality(const WrappedCycles& wrapped);
Orders orders_by_branch_cuts(const WrappedCycles& wrapped);
Orders orders_by_least_squares(const WrappedCycles& wrapped);
Orders orders_by_flow(const WrappedCycles& wrapped);

}  // namespace slipstream
