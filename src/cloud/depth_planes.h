#pragma once

#include <bit>
#include <cstdint>
#include <vector>

#include "cloud/depth_rows.h"
#include "slipstream/cleaner.h"

namespace slipstream {

/// 64 pixels of a row, the first in the lowest bit.
using Word = std::uint64_t;
inline constexpr int word_pixels = 64;

/// A bit for each pixel of a picture, with a border of zeros: a word before and after each row, two
/// rows above and below, and room for a block of words after the last.
class BitPlane {
 public:
  void prepare(Size picture) {
    const int stride = stride_of(picture), room = 2 * block_words / stride + 1;
    const Size size{stride, picture.height + 2 * border + room};
    if (bits_.size() != size) bits_ = Image<Word>(size);
  }
  [[nodiscard]] Word* row(int row) { return bits_.row(row + border) + 1; }
  [[nodiscard]] const Word* row(int row) const { return bits_.row(row + border) + 1; }
  /// The words of a block; row 0 begins the first.
  [[nodiscard]] Word* block(int block) { return row(0) + block * block_words; }
  [[nodiscard]] const Word* block(int block) const { return row(0) + block * block_words; }

  /// Words from row to row.
  static int stride_of(Size picture) { return (picture.width + word_pixels - 1) / word_pixels + 1; }
  static int blocks_of(Size picture) {
    return (picture.height * stride_of(picture) + block_words - 1) / block_words;
  }

 private:
  static constexpr int border = 2;

  Image<Word> bits_;
};

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
  [[nodiscard]] RelationWords block(int block, Size picture) const {
    return {BitPlane::stride_of(picture), point.block(block),    trusted.block(block),
            to_right.block(block),        to_below.block(block), bent_along.block(block),
            bent_across.block(block)};
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
  void find(Size picture, const DepthPlanes& planes, const BitPlane& kept);

  /// Calls `visit` with each run of the components with fewer than `pixels` pixels.
  template <class Visit>
  void for_each_run_below(int pixels, const Visit& visit) const {
    for (std::uint32_t i = 0; i < runs_.size(); ++i) {
      if (pixels_[parent_[i]] < static_cast<std::uint32_t>(pixels)) visit(runs_[i]);
    }
  }

 private:
  std::uint32_t root(std::size_t run);

  std::vector<PixelRun> runs_;
  std::vector<std::uint32_t> parent_, pixels_;  ///< of each run; pixels: of a root's component
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
