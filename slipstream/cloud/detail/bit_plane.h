#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>

#include "slipstream/base/image.h"

namespace slipstream {

/// 64 pixels of a row, the first in the lowest bit.
using Word = std::uint64_t;
inline constexpr int word_pixels = 64;

/// A bit for each pixel of a picture. Beyond the picture all are zero: one word before and after
/// each row, and two rows above and below.
class BitPlane {
 public:
  void prepare(Size picture) {
    const Size size{words_of(picture) + 2, picture.height + 2 * border};
    if (bits_.size() != size) bits_ = Image<Word>(size);
  }
  void clear() { std::fill(bits_.begin(), bits_.end(), Word{0}); }
  [[nodiscard]] Word* row(int row) { return bits_.row(row + border) + 1; }
  [[nodiscard]] const Word* row(int row) const { return bits_.row(row + border) + 1; }

  static int words_of(Size picture) { return (picture.width + word_pixels - 1) / word_pixels; }

 private:
  static constexpr int border = 2;

  Image<Word> bits_;
};

// For each pixel the bit of another one of its row. `row` points to the word that the pixels are
// in.

/// Of the pixel `distance` before it, below 64.
inline Word before(const Word* row, int distance = 1) {
  return row[0] << distance | row[-1] >> (word_pixels - distance);
}
/// Of the pixel `distance` after it.
inline Word after(const Word* row, int distance = 1) {
  return row[0] >> distance | row[1] << (word_pixels - distance);
}

/// Calls `visit(column)` for each bit that is set, from left to right. `word`: the bits' place in
/// the row.
template <class Visit>
void for_each_bit(Word bits, int word, const Visit& visit) {
  for (; bits != 0; bits &= bits - 1) visit(word * word_pixels + std::countr_zero(bits));
}

/// What neighbours have to do with each other, see DepthRow.
struct DepthPlanes {
  BitPlane point, trusted, to_right, to_below, bent_along, bent_across;

  void prepare(Size picture) {
    for (BitPlane* plane : {&point, &trusted, &to_right, &to_below, &bent_along, &bent_across}) {
      plane->prepare(picture);
    }
  }
};

}  // namespace slipstream
