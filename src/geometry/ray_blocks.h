#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "geometry/ray_table.h"
#include "slipstream/image.h"

namespace slipstream {

struct StripeGeometry;

/// StripeGeometry and RayTable as polynomials, one set for each block of adjacent pixels of a row.
/// Their variables are t, the column from the block's middle in half block widths, and p, the
/// projector coordinate mapped to [-1, 1]:
///   1/Z = sum c_k p^k + t sum d_k p^k + t^2 sum e_k p^k + t^3 f, projector lens included;
///   E_x and E_y are cubics in t.
/// The coefficients are stored at every eighth row, the knots, with quadratic interpolation through
/// three knots in between.
struct RayBlocks {
  static constexpr int width = 32;  ///< pixels of a block; the last of a row may overlap another
  static constexpr int spacing = 8;
  static constexpr int constants = 9, slopes = 7, bends = 4, twists = 1;  ///< terms c, d, e, f
  static constexpr int ray_terms = 4;

  /// The coefficients c, d, e, f, then those for E_x and E_y; the rest is padding.
  struct alignas(64) Block {
    static constexpr int E_x = constants + slopes + bends + twists, E_y = E_x + ray_terms;
    std::array<float, 32> coefficients{};
  };

  Image<Block> knots;          ///< column: the block, row: the knot
  std::vector<int> knot_rows;  ///< image row of each knot

  /// A range of p; empty by default.
  struct Range {
    float least = 1, largest = -1;
  };
  /// For each block and knot: the range of p in which the polynomials, interpolated from this knot
  /// and the next two, are valid for all rows to the next knot, or from the third knot from the end
  /// to the last row. Every ray of the block has a point there, in the field or its margin.
  Image<Range> described;

  /// Interpolation for the blocks of one row of pixels: each is the sum of `weights` times the
  /// blocks at `knots`, valid within its range `described`.
  struct Row {
    std::array<const Block*, 3> knots{};
    std::array<float, 3> weights{};
    const Range* described = nullptr;
  };
  [[nodiscard]] Row at(int row) const;

  /// The first pixel of block `i` in rows of `row_width` pixels.
  static constexpr int first_column(int i, int row_width) {
    return std::min(i * width, row_width - width);
  }
};

/// The blocks of an image. Within the range `described`, depths correspond to coordinate errors of
/// at most 1e-6 of the field, and E_x, E_y are accurate to 2.5e-7. nullopt for images narrower than
/// a block or less than five knots high, and for a solved lens.
std::optional<RayBlocks> ray_blocks(const StripeGeometry& geometry, const RayTable& rays);

}  // namespace slipstream
