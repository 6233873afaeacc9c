#pragma once

#include <bit>

#include "slipstream/cloud/cleaner.h"

namespace slipstream {

/// 64 pixels of a row, the first in the lowest bit.
using Word = std::uint64_t;
inline constexpr int word_pixels = 64;

/// A bit for each pixel of a picture, with a border of zeros: one word before and after each row,
/// and two rows above and below.
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

// Bits of other pixels of the row; `row` points to the word of the pixels.

/// The bit of the pixel `distance` before, below 64.
inline Word before(const Word* row, int distance = 1) {
  return row[0] << distance | row[-1] >> (word_pixels - distance);
}
/// The bit of the pixel `distance` after.
inline Word after(const Word* row, int distance = 1) {
  return row[0] >> distance | row[1] << (word_pixels - distance);
}

/// Calls `visit(column)` for each bit set, from left to right; `word`: index of the word in the
/// row.
template <class Visit>
void for_each_bit(Word bits, int word, const Visit& visit) {
  for (; bits != 0; bits &= bits - 1) visit(word * word_pixels + std::countr_zero(bits));
}

/// Relations between neighbours, see DepthRow.
struct DepthPlanes {
  BitPlane point, trusted, to_right, to_below, bent_along, bent_across;

  void prepare(Size picture) {
    for (BitPlane* plane : {&point, &trusted, &to_right, &to_below, &bent_along, &bent_across}) {
      plane->prepare(picture);
    }
  }
};

/// Neighbouring pixels of a row that are linked.
struct PixelRun {
  int row = 0, first = 0, last = 0;
};

/// Components of linked pixels, found over runs instead of pixels. Reuses its memory.
class Components {
 public:
  /// Finds the components of the pixels in `kept`; ignores links to and from others.
  void find(Size picture, const BitPlane& kept, const BitPlane& to_right, const BitPlane& to_below);

  /// Calls `visit` with each run of the components with fewer than `pixels` pixels.
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

/// Steps and bends beyond which a cloud has an edge, from samples of its distance between pixels
/// and its noise of depth, both relative to the depth. `samples`: reused memory. Infinite, without
/// any edge, if the cloud has too few points.
DepthLimits depth_limits(const Cloud& cloud, std::vector<float>& samples);

/// Memory reused from cloud to cloud.
struct SurfaceMemory {
  struct Point {
    int column = 0, row = 0;
    float x = 0, y = 0, z = 0;
  };
  std::vector<Point> found;
  Image<float> z;
};

/// Fills gaps in rows and columns of at most `widest` pixels between points of one surface, by
/// linear interpolation, averaged over both directions. Does not fill pixels outside the requested
/// region or range. Returns the number of points added.
std::size_t fill_gaps(Cloud& cloud, int widest, const DepthLimits& limits, SurfaceMemory& memory);

/// Moves each point along its ray to the mean of the pairs of points on opposite sides, up to
/// `reach` pixels away, that bend no more than one surface does. Preserves planes.
void smooth(Cloud& cloud, int reach, const DepthLimits& limits, SurfaceMemory& memory);

}  // namespace slipstream
