#include "reconstruct/fused/kept_rows.h"

#include <algorithm>
#include <cstdint>
#include <limits>

namespace slipstream {

void KeptRows::prepare(int width, int count) {
  if (flags_.size() == Size{width, count}) return;

  coordinate_ = Image<float>({width + 2 * side, count}, std::numeric_limits<float>::quiet_NaN());
  flags_ = Image<std::int32_t>({width, count});
}

void KeptRows::clear(int first, int last) {
  for (int row = first; row < last; ++row) {
    std::fill_n(coordinates(row), width(), std::numeric_limits<float>::quiet_NaN());
  }
}

}  // namespace slipstream
