// Cuts between residues whose charges cancel, which no way may cross: Goldstein, Zebker and Werner,
// Radio Science 23 (1988). A cut runs between pixels, as Huntley's do, and takes none of them away.
#include <cmath>
#include <cstdlib>
#include <utility>
#include <vector>

#include "slipstream/spatial/detail/methods.h"

namespace slipstream {
namespace {

/// Where four pixels meet, the lower right of them (x, y).
struct Corner {
  int x = 0, y = 0;
};

class BranchCuts {
 public:
  explicit BranchCuts(const WrappedCycles& wrapped)
      : steps_(edge_steps(wrapped.cycles)), corners_(charges_of(steps_)), tree_(corners_.size()) {
    // What is not between four pixels is the border.
    const auto has = [&](int x, int y) {
      return x >= 0 && y >= 0 && x < wrapped.cycles.width() && y < wrapped.cycles.height() &&
             !std::isnan(wrapped.cycles(x, y));
    };
    for (int y = 0; y < corners_.height(); ++y) {
      for (int x = 0; x < corners_.width(); ++x) {
        const bool inner = has(x - 1, y - 1) && has(x, y - 1) && has(x - 1, y) && has(x, y);
        if (!inner) corners_(x, y) = border;
      }
    }
  }

  /// The ways that are left.
  EdgeSteps placed() {
    for (int y = 0; y < corners_.height(); ++y) {
      for (int x = 0; x < corners_.width(); ++x) {
        if (is_residue({x, y}) && tree_(x, y) == 0) grow_tree({x, y});
      }
    }
    return std::move(steps_);
  }

 private:
  static constexpr int border = 100;

  struct Branch {
    Corner at;
    int searched = 0;  ///< so far around, corners
  };

  [[nodiscard]] bool is_residue(Corner at) const {
    return corners_(at.x, at.y) != 0 && corners_(at.x, at.y) != border;
  }

  /// Joins residues in boxes that grow until they cancel or the border is met.
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
    for (int dy = -radius; dy <= radius; ++dy) {
      for (int dx = -radius; dx <= radius; dx += std::abs(dy) == radius ? 1 : 2 * radius) {
        visit(from, {from.x + dx, from.y + dy});
        if (charge_ == 0) return;
      }
    }
  }

  void visit(Corner from, Corner to) {
    if (to.x < 0 || to.y < 0 || to.x >= corners_.width() || to.y >= corners_.height()) return;
    const int met = corners_(to.x, to.y);
    int& tree = tree_(to.x, to.y);
    if (met == 0 || tree == trees_) return;
    if (met == border) {
      charge_ = 0;
    } else {
      if (tree == 0) charge_ += met;  // others cancel already
      tree = trees_;
      branches_.push_back({to});
    }
    cut(from, to);
  }

  /// A staircase along the straight line.
  void cut(Corner at, Corner to) {
    const int wide = std::abs(to.x - at.x), high = std::abs(to.y - at.y);
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
  Image<int> corners_;  ///< their charges, and where cuts may end
  Image<int> tree_;     ///< the last that each residue is of, from 1
  std::vector<Branch> branches_{};
  int charge_ = 0;
  int trees_ = 0;
};

}  // namespace

Orders orders_by_branch_cuts(const WrappedCycles& wrapped) {
  return flood(wrapped, BranchCuts(wrapped).placed());
}

}  // namespace slipstream
