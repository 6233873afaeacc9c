#pragma once

#include <cstdint>
#include <vector>

#include "slipstream/cloud/detail/bit_plane.h"

namespace slipstream {

/// Neighbouring pixels of a row that are linked.
struct PixelRun {
  int row = 0;
  int first = 0;
  int last = 0;  ///< likewise of it
};

/// Components of linked pixels, found over runs instead of pixels. Memory is kept.
class Components {
 public:
  /// Of the pixels that `kept` has. Links to and from others do not count.
  void find(Size picture, const BitPlane& kept, const BitPlane& to_right, const BitPlane& to_below);

  /// Calls `visit` with each run of the components of fewer pixels than that.
  template <class Visit>
  void for_each_run_below(int pixels, const Visit& visit) {
    for (std::uint32_t i = 0; i < runs_.size(); ++i) {
      if (pixels_[root(i)] < static_cast<std::uint32_t>(pixels)) visit(runs_[i]);
    }
  }

 private:
  void find_runs(int row, int words, const Word* kept, const Word* to_right);
  void link_rows(int words, const Word* kept_above, const Word* kept, const Word* to_right_above,
                 const Word* to_right, const Word* to_below);
  std::uint32_t root(std::uint32_t run);
  void unite(std::uint32_t a, std::uint32_t b);

  std::vector<PixelRun> runs_;
  std::vector<std::uint32_t> parent_, pixels_;  ///< of each run; pixels: of a root's component
  std::uint32_t first_above_ = 0, first_here_ = 0;
};

}  // namespace slipstream
