#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "slipstream/geometry/ray_table.h"
#include "slipstream/image/image.h"

namespace slipstream {

struct StripeGeometry;

/// What StripeGeometry and RayTable say of a block of neighbouring pixels of a row, as polynomials
/// in t, the column from the block's middle in half blocks, and p, the coordinate mapped to
/// [-1, 1]: 1/Z as the sum of c_k p^k + t d_k p^k + t^2 e_k p^k + t^3 f, projector lens included,
/// and E_x, E_y as cubics in t. Kept at every eighth row; between them the coefficients are
/// quadratic.
struct RayBlocks {
  static constexpr int width = 32;  ///< pixels of a block; a row's last one may overlap another
  static constexpr int spacing = 8;
  static constexpr int constants = 9, slopes = 7, bends = 4, twists = 1;  ///< terms c, d, e, f
  static constexpr int ray_terms = 4;

  /// The coefficients in the order in which they are named, then some that mean nothing.
  struct alignas(64) Block {
    static constexpr int E_x = constants + slopes + bends + twists, E_y = E_x + ray_terms;
    std::array<float, 32> coefficients{};
  };

  Image<Block> knots;
  std::vector<int> knot_rows;

  /// Of the coordinates mapped to [-1, 1]; empty as it is made.
  struct Range {
    float least = 1, largest = -1;
  };
  /// For each block and knot, within what range the rows from there to the next are described by
  /// that one and the two after it: every ray has its point there, in the field and its margin.
  Image<Range> described;

  /// Of one row of pixels: each block is the sum of `weights` times those at `knots`.
  struct Row {
    std::array<const Block*, 3> knots{};
    std::array<float, 3> weights{};
    const Range* described = nullptr;
  };
  [[nodiscard]] Row at(int row) const;

  /// Of block `i` in rows of `row_width` pixels.
  static constexpr int first_column(int i, int row_width) {
    return std::min(i * width, row_width - width);
  }
};

/// To 1e-6 of the field in the coordinate and 2.5e-7 in E_x, E_y where it is `described`. None for
/// pictures less than a block wide or less than five knots high.
std::optional<RayBlocks> ray_blocks(const StripeGeometry& geometry, const RayTable& rays);

}  // namespace slipstream
