#include "slipstream/cloud/detail/components.h"

#include <utility>

namespace slipstream {

void Components::find(Size picture, const BitPlane& kept, const BitPlane& to_right,
                      const BitPlane& to_below) {
  runs_.clear();
  parent_.clear();
  pixels_.clear();
  const int words = BitPlane::words_of(picture);
  first_here_ = 0;
  for (int row = 0; row < picture.height; ++row) {
    first_above_ = std::exchange(first_here_, static_cast<std::uint32_t>(runs_.size()));
    find_runs(row, words, kept.row(row), to_right.row(row));
    if (row == 0) continue;
    link_rows(words, kept.row(row - 1), kept.row(row), to_right.row(row - 1), to_right.row(row),
              to_below.row(row - 1));
  }
}

void Components::find_runs(int row, int words, const Word* kept, const Word* to_right) {
  std::size_t begun = runs_.size();
  Word linked_before = 0;  // whether the last pixel of the word before is linked with this one's
  for (int w = 0; w < words; ++w) {
    const Word linked = to_right[w] & kept[w] & after(kept + w);
    for_each_bit(kept[w] & ~(linked << 1 | linked_before), w, [&](int column) {
      runs_.push_back({row, column, column});
    });
    for_each_bit(kept[w] & ~linked, w, [&](int column) { runs_[begun++].last = column; });
    linked_before = linked >> (word_pixels - 1);
  }
  for (std::size_t i = parent_.size(); i < runs_.size(); ++i) {
    parent_.push_back(static_cast<std::uint32_t>(i));
    pixels_.push_back(static_cast<std::uint32_t>(runs_[i].last - runs_[i].first + 1));
  }
}

void Components::link_rows(int words, const Word* kept_above, const Word* kept,
                           const Word* to_right_above, const Word* to_right, const Word* to_below) {
  std::uint32_t above = first_above_, here = first_here_;
  Word same_before = 0;  // as below, of the last pixel of the word before
  for (int w = 0; w < words; ++w) {
    const Word linked = to_below[w] & kept_above[w] & kept[w];
    // The next column links the same two runs.
    const Word same =
        linked & to_right_above[w] & to_right[w] & after(kept_above + w) & after(kept + w);
    for_each_bit(linked & ~(same << 1 | same_before), w, [&](int column) {
      while (runs_[above].last < column) ++above;
      while (runs_[here].last < column) ++here;
      unite(above, here);
    });
    same_before = same >> (word_pixels - 1);
  }
}

std::uint32_t Components::root(std::uint32_t run) {
  while (parent_[run] != run) run = parent_[run] = parent_[parent_[run]];
  return run;
}

void Components::unite(std::uint32_t a, std::uint32_t b) {
  a = root(a);
  b = root(b);
  if (a == b) return;
  if (a > b) std::swap(a, b);
  parent_[b] = a;
  pixels_[a] += pixels_[b];
}

}  // namespace slipstream
