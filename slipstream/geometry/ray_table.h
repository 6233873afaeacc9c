#pragma once

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "slipstream/base/image.h"
#include "slipstream/geometry/lens.h"

namespace slipstream {

/// E_x, E_y of Liu 2010, Eqs. (2.30), (2.31), in the camera's own frame, where F_x = F_y = 0: the
/// ray through each pixel is (E_x, E_y, 1) Z. Camera distortion included. All of the third form's
/// other tables are functions of these two and of constants: see StripeGeometry.
struct RayTable {
  Image<float> E_x;
  Image<float> E_y;
};

/// Exact at every eighth pixel and cubic between, which takes 640x480 a few milliseconds; exact at
/// every pixel where the cubic would miss a ray by more than 1e-7, as in small pictures. None where
/// some pixel has no ray.
std::optional<RayTable> ray_table(const Lens& camera);

struct StripeGeometry;

/// StripeGeometry and RayTable as polynomials, one set for each block of neighbouring pixels of a
/// row. Their variables are t, the column counted from the block's middle in half widths of a
/// block, and p, the projector coordinate mapped to [-1, 1]:
///   1/Z = sum c_k p^k + t sum d_k p^k + t^2 sum e_k p^k + t^3 f, projector lens included;
///   E_x and E_y are cubics in t.
/// The coefficients are kept at every eighth row, the knots, and are interpolated between them by a
/// quadratic through three knots.
struct RayBlocks {
  static constexpr int width = 32;  ///< pixels of a block; a row's last one may overlap another
  static constexpr int spacing = 8;
  static constexpr int constants = 9, slopes = 7, bends = 4, twists = 1;  ///< terms c, d, e, f
  static constexpr int ray_terms = 4;

  /// The coefficients c, d, e, f, then those of E_x and of E_y; the rest is padding.
  struct alignas(64) Block {
    static constexpr int E_x = constants + slopes + bends + twists, E_y = E_x + ray_terms;
    std::array<float, 32> coefficients{};
  };

  Image<Block> knots;          ///< column: the block, row: the knot
  std::vector<int> knot_rows;  ///< the row of pixels that each knot stands for

  /// A range of p; the default is empty.
  struct Range {
    float least = 1, largest = -1;
  };
  /// For each block and knot: the range of p in which the polynomials hold for all rows from this
  /// knot to the next, interpolated from this knot and the two after it. Every ray of the block has
  /// a point there, in the field or its margin. The third knot from the end stands for all rows to
  /// the last.
  Image<Range> described;

  /// What gives the blocks of one row of pixels: each is the sum of `weights` times the blocks at
  /// `knots`, and holds within its range `described`.
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

/// The blocks of a picture. Within the range `described` depths are those of coordinates at most
/// 1e-6 of the field away, and E_x, E_y are right to 2.5e-7. None for pictures less than a block
/// wide or less than five knots high.
std::optional<RayBlocks> ray_blocks(const StripeGeometry& geometry, const RayTable& rays);

}  // namespace slipstream
