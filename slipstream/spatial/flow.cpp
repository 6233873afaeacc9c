// The least change of the steps that makes every way around close, a flow of least cost between
// residues: Costantini, IEEE Transactions on Geoscience and Remote Sensing 36 (1998).
#include <algorithm>
#include <vector>

#include <lemon/network_simplex.h>
#include <lemon/smart_graph.h>

#include "slipstream/spatial/detail/edge_steps.h"
#include "slipstream/spatial/detail/phase_groups.h"
#include "slipstream/spatial/detail/roughness.h"

namespace slipstream {
namespace {

using Graph = lemon::SmartDigraph;

/// Calls `visit(step, first, second, from, to)` for each edge between the pixels `from` and `to`,
/// or where there is none, and the corners on its sides: a flow from the first to the second takes
/// away from the step.
template <class Visit>
void for_each_edge(EdgeSteps& steps, const Visit& visit) {
  const auto [width, height] = steps.size();
  const int wide = width + 1;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const int at = y * width + x, corner = y * wide + x;
      visit(steps.right(x, y), corner + 1 + wide, corner + 1, at, at + 1);
      visit(steps.down(x, y), corner + wide, corner + wide + 1, at, at + width);
    }
  }
}

/// Corners that no edge keeps apart are one: those around a hole, and
/// those around the picture.
PhaseGroups corner_groups(EdgeSteps& steps) {
  const auto [width, height] = steps.size();
  const int wide = width + 1;
  PhaseGroups groups(static_cast<std::size_t>(wide) * static_cast<std::size_t>(height + 1));
  for (int x = 0; x < width; ++x) groups.join(x, x + 1, 0);
  for (int y = 0; y < height; ++y) groups.join(y * wide, (y + 1) * wide, 0);
  for_each_edge(steps, [&](std::int16_t step, int first, int second, int, int) {
    if (step == EdgeSteps::closed) groups.join(first, second, 0);
  });
  return groups;
}

}  // namespace

Orders orders_by_flow(const WrappedCycles& wrapped) {
  EdgeSteps steps = edge_steps(wrapped.cycles);
  PhaseGroups groups = corner_groups(steps);
  const std::vector<int> nodes = groups.numbered();
  const Image<int> charges = charges_of(steps);
  std::vector<int> residues(groups.count());
  for (std::size_t i = 0; i < nodes.size(); ++i) {
    residues[static_cast<std::size_t>(nodes[i])] += charges.begin()[i];
  }
  if (std::count(residues.begin(), residues.end(), 0) == std::ssize(residues)) {
    return flood(wrapped, steps);
  }
  Graph graph;
  graph.reserveNode(static_cast<int>(residues.size()));
  while (graph.maxNodeId() + 1 < std::ssize(residues)) graph.addNode();
  Graph::NodeMap<int> supplies(graph);
  for (int i = 0; i < std::ssize(residues); ++i) {
    supplies[Graph::nodeFromId(i)] = residues[static_cast<std::size_t>(i)];
  }

  const Image<float> weights = smoothness(wrapped);
  std::vector<std::int16_t*> crossed;
  std::vector<int> costs;
  for_each_edge(steps, [&](std::int16_t& step, int first, int second, int from, int to) {
    const int a = nodes[static_cast<std::size_t>(first)],
              b = nodes[static_cast<std::size_t>(second)];
    if (step == EdgeSteps::closed || a == b) return;
    graph.addArc(Graph::nodeFromId(a), Graph::nodeFromId(b));
    graph.addArc(Graph::nodeFromId(b), Graph::nodeFromId(a));
    crossed.push_back(&step);
    // By how much the square of the difference grows: what is nearly half a period gives way first.
    const float rest =
        wrapped.cycles.begin()[to] - wrapped.cycles.begin()[from] + static_cast<float>(step);
    const float weight = 100 * std::min(weights.begin()[from], weights.begin()[to]);
    costs.push_back(1 + static_cast<int>(weight * (1 - 2 * rest)));
    costs.push_back(1 + static_cast<int>(weight * (1 + 2 * rest)));
  });
  Graph::ArcMap<int> cost(graph);
  for (std::size_t i = 0; i < costs.size(); ++i)
    cost[Graph::arcFromId(static_cast<int>(i))] = costs[i];
  lemon::NetworkSimplex<Graph, int, long> solver(graph);
  solver.supplyMap(supplies).costMap(cost).run(decltype(solver)::CANDIDATE_LIST);
  for (std::size_t i = 0; i < crossed.size(); ++i) {
    const auto arc = static_cast<int>(2 * i);
    const int flow = solver.flow(Graph::arcFromId(arc)) - solver.flow(Graph::arcFromId(arc + 1));
    *crossed[i] = static_cast<std::int16_t>(*crossed[i] - flow);
  }
  return flood(wrapped, steps);
}

}  // namespace slipstream
