#pragma once

#include <cstdint>

#include "reconstruct/fused/rows.h"
#include "slipstream/image.h"

namespace slipstream {

/// Ring buffer of the last rows of coordinates and flags.
class KeptRows {
 public:
  /// Padding columns before and after each row: NaN, so that they confirm no neighbour, and one
  /// full vector wide, so that rows start at whole vectors.
  static constexpr int side = least_row_width;

  /// Allocates `count` rows, a power of two, of `width` pixels, unless they are there already.
  void prepare(int width, int count);
  /// Sets coordinates to NaN in rows outside the image or not yet decoded.
  void clear(int first, int last);

  [[nodiscard]] int width() const { return flags_.width(); }
  [[nodiscard]] float* coordinates(int row) { return coordinate_.row(place(row)) + side; }
  [[nodiscard]] std::int32_t* flags(int row) { return flags_.row(place(row)); }

 protected:
  [[nodiscard]] int place(int row) const { return row & (flags_.height() - 1); }

  Image<float> coordinate_;
  Image<std::int32_t> flags_;
};

}  // namespace slipstream
