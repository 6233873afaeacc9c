// Graph cuts that raise pixels by a period each, as long as that makes the phase smoother: PUMA,
// Bioucas-Dias and Valadao, IEEE Transactions on Image Processing 16 (2007). From what quality
// gives on, pixels that are safely one joined beforehand.
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <lemon/preflow.h>
#include <lemon/smart_graph.h>

#include "slipstream/spatial/detail/edge_steps.h"
#include "slipstream/spatial/detail/phase_groups.h"
#include "slipstream/spatial/detail/roughness.h"

namespace slipstream {
namespace {

using Graph = lemon::SmartDigraph;

/// What a difference of phase between neighbours, in periods, costs: as a square where noise makes
/// it, less beyond, so that one cliff is better than many steps.
float cost_of(float periods) {
  constexpr float small = 0.25F;
  const float size = std::abs(periods) / small;
  return size < 1 ? size * size : std::sqrt(size);
}

/// Two neighbours of two groups.
struct Neighbours {
  int first = 0, second = 0;  ///< their groups
  float apart = 0;            ///< periods
  float weight = 0;
};

struct Graded {
  double cost = 0;
  std::vector<bool> is_raised;  ///< the groups that are to be raised, so that it falls the most
};

Graded graded(const std::vector<Neighbours>& pairs, const std::vector<int>& orders) {
  constexpr float levels = 20;  // of capacity
  const auto groups = static_cast<int>(orders.size());
  Graded result{0, std::vector<bool>(orders.size())};
  Graph graph;
  while (graph.maxNodeId() <= groups) graph.addNode();  // the last two are the ends
  std::vector<int> capacities;
  const auto add = [&](int from, int to, float capacity) {
    const auto whole = static_cast<int>(std::lrint(levels * capacity));
    if (whole <= 0) return;
    graph.addArc(Graph::nodeFromId(from), Graph::nodeFromId(to));
    capacities.push_back(whole);
  };
  std::vector<float> own(orders.size());
  for (const auto& [first, second, apart, weight] : pairs) {
    float& of_first = own[static_cast<std::size_t>(first)];
    float& of_second = own[static_cast<std::size_t>(second)];
    const float now = apart + static_cast<float>(orders[static_cast<std::size_t>(second)] -
                                                 orders[static_cast<std::size_t>(first)]);
    const float same = weight * cost_of(now), up = weight * cost_of(now + 1) - same,
                down = weight * cost_of(now - 1) - same;
    result.cost += static_cast<double>(same);
    of_first += down;
    of_second -= down;
    add(first, second, up + down);
  }
  for (int i = 0; i < groups; ++i) {
    const float alone = own[static_cast<std::size_t>(i)];
    alone > 0 ? add(groups, i, alone) : add(i, groups + 1, -alone);
  }
  Graph::ArcMap<int> capacity(graph);
  for (std::size_t i = 0; i < capacities.size(); ++i) {
    capacity[Graph::arcFromId(static_cast<int>(i))] = capacities[i];
  }
  lemon::Preflow<Graph, Graph::ArcMap<int>> solver(graph, capacity, Graph::nodeFromId(groups),
                                                   Graph::nodeFromId(groups + 1));
  solver.runMinCut();
  for (int i = 0; i < groups; ++i) {
    result.is_raised[static_cast<std::size_t>(i)] = !solver.minCut(Graph::nodeFromId(i));
  }
  return result;
}

/// How often each group is to be raised.
std::vector<int> raised(const std::vector<Neighbours>& pairs, std::size_t groups) {
  std::vector<int> best(groups), orders(groups);
  for (double least = std::numeric_limits<double>::infinity();;) {
    const Graded now = graded(pairs, orders);
    if (now.cost >= (1 - 1e-6) * least) return best;
    least = now.cost;
    best = orders;
    for (std::size_t i = 0; i < groups; ++i) orders[i] += now.is_raised[i] ? 1 : 0;
  }
}

}  // namespace

Orders orders_by_cuts(const WrappedCycles& wrapped) {
  constexpr float nearest = 0.25F;  // periods
  Orders orders = orders_by_quality(wrapped);
  const EdgeSteps steps = edge_steps(wrapped.cycles);
  const Image<float> weights = smoothness(wrapped);
  const auto pixels = static_cast<int>(weights.pixel_count());
  // Of each pair of neighbours once.
  const auto for_each_pair = [&](const auto& visit) {
    for (int at = 0; at < pixels; ++at) {
      steps.for_each_neighbour(at, [&](int to, int) {
        if (to < at) return;
        const float apart = wrapped.cycles.begin()[to] - wrapped.cycles.begin()[at] +
                            static_cast<float>(orders.order.begin()[to] - orders.order.begin()[at]);
        visit(at, to, apart, std::min(weights.begin()[at], weights.begin()[to]));
      });
    }
  };
  PhaseGroups groups(weights.pixel_count());
  for_each_pair([&](int at, int to, float apart, float weight) {
    if (std::abs(apart) < nearest && weight > 0.5F) groups.join(at, to, 0);
  });
  const std::vector<int> group = groups.numbered();
  std::vector<Neighbours> pairs;
  for_each_pair([&](int at, int to, float apart, float weight) {
    const int first = group[static_cast<std::size_t>(at)],
              second = group[static_cast<std::size_t>(to)];
    if (first != second) pairs.push_back({first, second, apart, weight});
  });
  const std::vector<int> more = raised(pairs, groups.count());
  for (int at = 0; at < pixels; ++at)
    orders.order.begin()[at] += more[static_cast<std::size_t>(group[static_cast<std::size_t>(at)])];
  return orders;
}

}  // namespace slipstream
