// Minimum-cost flow between residues, the cheapest change of steps that closes every loop:
// Costantini, IEEE Transactions on Geoscience and Remote Sensing 36 (1998).

#include <algorithm>
#include <cstdint>
#include <vector>

#include <lemon/bucket_heap.h>
#include <lemon/maps.h>

#include "spatial/methods.h"

namespace slipstream {
namespace {

/// The network of pixel corners; flow across an edge changes its step. Successive shortest paths:
/// residues are few and close to each other, so each search is short, and no network of all edges
/// has to be built.
class CornerFlow {
 public:
  CornerFlow(const WrappedCycles& wrapped, EdgeSteps& steps)
      : wrapped_(wrapped),
        steps_(steps),
        size_(steps.size()),
        wide_(size_.width + 1),
        residues_(charges_of(steps)) {
    merge_corners();
  }

  /// Changes the steps so that all loops close.
  void run() {
    if (std::ranges::all_of(residues_, [](int residue) { return residue == 0; })) return;

    const std::size_t corners = residues_.pixel_count();
    weights_ = smoothness(wrapped_);
    potentials_.resize(corners);
    arrivals_.resize(corners);
    places_.resize(static_cast<int>(corners), Heap::PRE_HEAP);

    // Start searches inside, not at the border, which has edges to every side.
    if (residue(nodes_[0]) > 0) {
      turn_ = -1;
      for (int& residue : residues_) residue = -residue;
    }

    for (int source = 0; source < static_cast<int>(corners); ++source) {
      while (residue(source) > 0) send_from(source);
    }
  }

 private:
  using Places = lemon::RangeMap<int>;
  using Heap = lemon::BucketHeap<Places>;

  /// An arc across the edge between pixels `from` and `to`; flow changes the edge's step.
  struct Arc {
    std::int16_t* step = nullptr;  ///< null without an edge
    int from = 0, to = 0, change = 0;
    int target = 0;  ///< corner
  };

  int& residue(int corner) { return residues_.begin()[corner]; }

  /// `direction`: up, down, right, left.
  Arc arc(int corner, int direction) {
    const bool sideways = direction >= 2;

    // The pixel to the left of the edge or above it.
    const int x = corner % wide_ - (direction == 2 ? 0 : 1),
              y = corner / wide_ - (direction == 1 ? 0 : 1);
    if (x < 0 || y < 0 || x >= size_.width || y >= size_.height) return {};

    const int from = y * size_.width + x;
    std::int16_t* const step = (sideways ? steps_.down : steps_.right).begin() + from;
    if (*step == EdgeSteps::closed) return {};

    // Up and right decrease the step, down and left increase it: see charges_of.
    const bool back = direction == 1 || direction == 3;
    const int stride = sideways ? 1 : wide_, forth = sideways ? stride : -stride;
    return {step, from, from + (sideways ? size_.width : 1), back ? turn_ : -turn_,
            corner + (back ? -forth : forth)};
  }

  /// Merges corners without an edge between them into one node, named by one of them: the corners
  /// around a hole, and around the picture. A node lists its corners that have an edge.
  void merge_corners() {
    const auto [width, height] = size_;

    // The border of the picture: its left column and upper row; the rest follows from closed edges.
    PhaseGroups groups(residues_.pixel_count());
    for (int x = 0; x < width; ++x) groups.join(x, x + 1, 0);
    for (int y = 0; y < height; ++y) groups.join(y * wide_, (y + 1) * wide_, 0);

    for_each_pixel_in_order(size_, [&](int x, int y) {
      const int after = (y + 1) * wide_ + x + 1;  // the corner below and to the right
      if (steps_.right(x, y) == EdgeSteps::closed) groups.join(after, after - wide_, 0);
      if (steps_.down(x, y) == EdgeSteps::closed) groups.join(after, after - 1, 0);
    });

    nodes_.resize(residues_.pixel_count());
    others_.resize(residues_.pixel_count(), -1);
    for (int corner = 0; corner < static_cast<int>(nodes_.size()); ++corner) {
      const int first = nodes_[corner] = groups.find(corner).group;
      if (first == corner) continue;

      residue(first) += residue(corner);
      residue(corner) = 0;

      // Only corners with an edge are listed: the search would find no way from the others.
      for (int direction = 0; direction < 4; ++direction) {
        if (arc(corner, direction).step == nullptr) continue;
        others_[corner] = others_[first];
        others_[first] = corner;
        break;
      }
    }
  }

  /// Undoing a change refunds its cost.
  int cost(const Arc& arc) const {
    const float* const cycles = wrapped_.cycles.begin();
    const int changed = *arc.step - step_between(cycles[arc.from], cycles[arc.to]);

    return changed * arc.change < 0
               ? -cost_of_change(wrapped_, weights_, arc.from, arc.to, -arc.change)
               : cost_of_change(wrapped_, weights_, arc.from, arc.to, arc.change);
  }

  /// Sends one unit to the cheapest node with a deficit.
  void send_from(int source) {
    // 1. Dijkstra's search over reduced costs, until it meets a deficit.
    heap_.push(source, 0);
    touched_.assign(1, source);
    settled_.clear();
    while (residue(heap_.top()) >= 0) {
      const int at = heap_.top(), distance = heap_.prio();
      heap_.pop();
      settled_.push_back({at, distance});

      for (int corner = at; corner >= 0; corner = others_[corner]) {
        for (int direction = 0; direction < 4; ++direction) {
          const Arc way = arc(corner, direction);
          if (way.step == nullptr) continue;

          const int next = nodes_[way.target];
          const auto state = heap_.state(next);
          if (state == Heap::POST_HEAP) continue;

          const int far = distance + cost(way) + potentials_[at] - potentials_[next];
          if (state == Heap::IN_HEAP && heap_[next] <= far) continue;
          if (state == Heap::PRE_HEAP) touched_.push_back(next);

          heap_.set(next, far);
          arrivals_[next] = 4 * corner + direction;
        }
      }
    }

    // 2. Updates the potentials, so that reduced costs stay non-negative, and clears the heap.
    const int sink = heap_.top(), farthest = heap_.prio();
    for (const auto& [at, distance] : settled_) potentials_[at] += distance - farthest;

    heap_.clear();
    for (const int at : touched_) places_[at] = Heap::PRE_HEAP;

    // 3. Changes the steps along the path, from the sink back to the source.
    for (int at = sink; at != source; at = nodes_[arrivals_[at] / 4]) {
      const Arc way = arc(arrivals_[at] / 4, arrivals_[at] % 4);
      *way.step = static_cast<std::int16_t>(*way.step + way.change);
    }

    --residue(source);
    ++residue(sink);
  }

  const WrappedCycles& wrapped_;
  EdgeSteps& steps_;
  Size size_;
  int wide_;  ///< corners in a row
  Image<int> residues_;
  Image<float> weights_;
  int turn_ = 1;  ///< -1: from deficits to surpluses, against the arcs
  std::vector<int> nodes_, others_, potentials_, arrivals_, touched_;
  std::vector<std::pair<int, int>> settled_;  ///< nodes and their distances
  Places places_;
  Heap heap_{places_};
};

}  // namespace

Orders orders_by_flow(const WrappedCycles& wrapped) {
  EdgeSteps steps = edge_steps(wrapped.cycles);
  CornerFlow(wrapped, steps).run();
  return flood(wrapped, steps);
}

}  // namespace slipstream
