// Methods that join pixels into groups, edge by edge.

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <functional>
#include <vector>

#include "spatial/methods.h"

namespace slipstream {
namespace {

/// The border of two regions, with the number of edges for each step from the first to the second.
struct Border {
  std::uint64_t regions = 0;
  std::array<int, 3> votes{};  ///< for -1, 0, 1 periods

  [[nodiscard]] int step() const {
    return static_cast<int>(std::max_element(votes.begin(), votes.end()) - votes.begin()) - 1;
  }

  [[nodiscard]] int lead() const {
    return 2 * *std::max_element(votes.begin(), votes.end()) - votes[0] - votes[1] - votes[2];
  }
};

/// The corner of four pixels; (x, y) is the lower right one.
struct Corner {
  int x = 0, y = 0;
};

/// Branch cuts between residues whose charges cancel; unwrapping must not cross them. Cuts run
/// between pixels, as Huntley's do, and remove none.
class BranchCuts {
 public:
  explicit BranchCuts(const WrappedCycles& wrapped)
      : steps_(edge_steps(wrapped.cycles)), corners_(charges_of(steps_)), tree_(corners_.size()) {
    // Corners that are not between four pixels are the border.
    const auto has = [&](int x, int y) {
      return x >= 0 && y >= 0 && x < wrapped.cycles.width() && y < wrapped.cycles.height() &&
             !std::isnan(wrapped.cycles(x, y));
    };

    for_each_pixel_in_order(corners_.size(), [&](int x, int y) {
      const bool inner = has(x - 1, y - 1) && has(x, y - 1) && has(x - 1, y) && has(x, y);
      if (!inner) corners_(x, y) = border;
    });
  }

  /// Places the cuts and returns the remaining edges.
  EdgeSteps placed() {
    for_each_pixel_in_order(corners_.size(), [&](int x, int y) {
      const bool is_residue = corners_(x, y) != 0 && corners_(x, y) != border;
      if (is_residue && tree_(x, y) == 0) grow_tree({x, y});
    });

    return std::move(steps_);
  }

 private:
  static constexpr int border = 100;

  struct Branch {
    Corner at;
    int searched = 0;  ///< radius searched so far, corners
  };

  /// Joins residues in growing boxes until they cancel or reach the border.
  void grow_tree(Corner root) {
    branches_ = {{root}};
    charge_ = corners_(root.x, root.y);
    tree_(root.x, root.y) = ++trees_;

    for (int radius = 1; charge_ != 0; ++radius) {
      for (std::size_t i = 0; i < branches_.size() && charge_ != 0; ++i) {
        while (branches_[i].searched < radius && charge_ != 0) search_ring(i);
      }
    }
  }

  void search_ring(std::size_t branch) {
    const Corner from = branches_[branch].at;
    const int radius = ++branches_[branch].searched;

    // All of the upper and lower side, but only both ends of the rows between.
    for (int dy = -radius; dy <= radius; ++dy) {
      for (int dx = -radius; dx <= radius; dx += std::abs(dy) == radius ? 1 : 2 * radius) {
        visit(from, {from.x + dx, from.y + dy});
        if (charge_ == 0) return;
      }
    }
  }

  void visit(Corner from, Corner to) {
    if (to.x < 0 || to.y < 0 || to.x >= corners_.width() || to.y >= corners_.height()) return;

    // Ignores corners without a charge or already in this tree.
    const int met = corners_(to.x, to.y);
    int& tree = tree_(to.x, to.y);
    if (met == 0 || tree == trees_) return;

    // The border absorbs any charge.
    if (met == border) {
      charge_ = 0;
    } else {
      if (tree == 0) charge_ += met;  // residues of other trees already cancel
      tree = trees_;
      branches_.push_back({to});
    }

    cut(from, to);
  }

  /// Cuts a staircase along the straight line.
  void cut(Corner at, Corner to) {
    const int wide = std::abs(to.x - at.x), high = std::abs(to.y - at.y);

    // Moves along the direction with the larger share of its distance left.
    while (at.x != to.x || at.y != to.y) {
      if (std::abs(to.x - at.x) * high >= std::abs(to.y - at.y) * wide && at.x != to.x) {
        const int left = to.x > at.x ? at.x++ : --at.x;
        if (at.y > 0 && at.y + 1 < corners_.height())
          steps_.down(left, at.y - 1) = EdgeSteps::closed;
      } else {
        const int above = to.y > at.y ? at.y++ : --at.y;
        if (at.x > 0 && at.x + 1 < corners_.width())
          steps_.right(at.x - 1, above) = EdgeSteps::closed;
      }
    }
  }

  EdgeSteps steps_;
  Image<int> corners_;  ///< charges, and the border, at which cuts may end
  Image<int> tree_;     ///< last tree of each residue, from 1
  std::vector<Branch> branches_{};
  int charge_ = 0, trees_ = 0;
};

}  // namespace

/// Counts fringes along each row, then links the rows where they first touch: Nakadate and Saito,
/// Applied Optics 24 (1985).
Orders orders_by_rows(const WrappedCycles& wrapped) {
  const EdgeSteps steps = edge_steps(wrapped.cycles);

  PhaseGroups groups(wrapped.cycles.pixel_count());
  steps.for_each_edge([&](int at, int to, int step) { groups.join(at, to, step); });

  return groups.orders(wrapped);
}

/// Excludes pixels with large second differences from the flood; they follow a neighbour
/// afterwards: Bone, Applied Optics 30 (1991).
Orders orders_by_flood(const WrappedCycles& wrapped) {
  constexpr float roughest = 0.04F;  // periods squared

  const EdgeSteps all = edge_steps(wrapped.cycles);
  const Image<float> rough = roughness({wrapped.cycles, {}});
  const auto is_rough = [&](int at) { return rough.begin()[at] > roughest; };

  // 1. Closes all edges of rough pixels.
  EdgeSteps open = all;
  std::vector<int> front, next;
  for (int at = 0; at < static_cast<int>(rough.pixel_count()); ++at) {
    if (!is_rough(at)) front.push_back(at);
    all.for_each_neighbour(at, [&](int to, int) {
      if (to > at && (is_rough(at) || is_rough(to))) open.edge(at, to) = EdgeSteps::closed;
    });
  }

  // 2. Reopens one edge per rough pixel: the one by which a breadth-first search reaches it.
  std::vector<bool> reached(rough.pixel_count());
  for (; !front.empty(); front.swap(next), next.clear()) {
    for (const int at : front) {
      all.for_each_neighbour(at, [&](int to, int step) {
        if (!is_rough(to) || reached[to]) return;
        reached[to] = true;
        open.edge(std::min(at, to), std::max(at, to)) =
            static_cast<std::int16_t>(to > at ? step : -step);
        next.push_back(to);
      });
    }
  }

  return flood(wrapped, open);
}

/// Joins the most reliable neighbours first (a minimum spanning tree): Judge, Quan and
/// Bryanston-Cross, Optical Engineering 31 (1992); reliability by second differences: Herraez et
/// al., Applied Optics 41 (2002).
Orders orders_by_quality(const WrappedCycles& wrapped) {
  EdgeSteps steps = edge_steps(wrapped.cycles);
  const Image<float> rough = roughness(wrapped);
  const int width = rough.width();

  // Non-negative floats sort like their bits.
  std::vector<std::uint64_t> edges;
  edges.reserve(2 * rough.pixel_count());
  steps.for_each_edge([&](int at, int to, int) {
    const auto both = std::bit_cast<std::uint32_t>(rough.begin()[at] + rough.begin()[to]);
    const std::uint64_t place = 2 * static_cast<std::uint64_t>(at) + (to - at == width ? 1 : 0);
    edges.push_back(std::uint64_t{both} << 32U | place);
  });
  std::sort(edges.begin(), edges.end());

  PhaseGroups groups(rough.pixel_count());
  for (const std::uint64_t edge : edges) {
    const auto at = static_cast<int>((edge & 0xffffffffU) >> 1U);
    const int to = at + ((edge & 1U) == 0 ? 1 : width);
    groups.join(at, to, steps.edge(at, to));
  }

  return groups.orders(wrapped);
}

/// Joins regions without a wrap, longest borders first: Gierloff, SPIE 818 (1987).
Orders orders_by_regions(const WrappedCycles& wrapped) {
  constexpr float largest_step = 0.25F;  // periods, within a region

  const EdgeSteps steps = edge_steps(wrapped.cycles);
  const float* const cycles = wrapped.cycles.begin();
  const auto pixels = static_cast<int>(wrapped.cycles.pixel_count());
  PhaseGroups groups(wrapped.cycles.pixel_count());

  // 1. Regions: neighbours whose phases differ by a small step, without a wrap.
  for (int at = 0; at < pixels; ++at) {
    steps.for_each_neighbour(at, [&](int to, int) {
      if (to > at && std::abs(cycles[to] - cycles[at]) <= largest_step) groups.join(at, to, 0);
    });
  }

  // 2. The votes of every edge between two regions.
  std::vector<Border> single, borders;
  for (int at = 0; at < pixels; ++at) {
    const auto from = static_cast<std::uint32_t>(groups.find(at).group);

    steps.for_each_neighbour(at, [&](int to, int step) {
      const auto other = static_cast<std::uint32_t>(groups.find(to).group);
      if (from >= other) return;  // each border is visited from both sides

      single.push_back({std::uint64_t{from} << 32U | other});
      single.back().votes[step + 1] = 1;
    });
  }

  // 3. The sum of the votes for each pair of regions.
  std::ranges::sort(single, {}, &Border::regions);
  for (const Border& each : single) {  // merges those of a pair of regions
    if (borders.empty() || borders.back().regions != each.regions)
      borders.push_back({each.regions});
    for (std::size_t i = 0; i < each.votes.size(); ++i) borders.back().votes[i] += each.votes[i];
  }

  // 4. Joins the regions, clearest borders first.
  std::ranges::stable_sort(borders, std::ranges::greater(), &Border::lead);
  for (const Border& border : borders) {
    groups.join(static_cast<int>(border.regions >> 32U),
                static_cast<int>(border.regions & 0xffffffffU), border.step());
  }

  return groups.orders(wrapped);
}

/// Floods between branch cuts: Goldstein, Zebker and Werner, Radio Science 23 (1988).
Orders orders_by_branch_cuts(const WrappedCycles& wrapped) {
  return flood(wrapped, BranchCuts(wrapped).placed());
}

}  // namespace slipstream
