#include "slipstream/reconstruct/detail/vote_block.h"

#include <algorithm>

namespace slipstream {

namespace {

constexpr float nothing = std::numeric_limits<float>::quiet_NaN();

}  // namespace

void VoteBlock::prepare(int width) {
  static_assert(kept_rows >= most_rows + 2 * (seen + looks_past));
  if (flags_.width() != width) {
    coordinate_ = Image<float>({width + 2 * side, kept_rows}, nothing);
    flags_ = Image<std::int32_t>({width, kept_rows});
    shift_ = Image<std::int16_t>({width + 2 * side, kept_rows});
    below_ = Image<float>({width + 2 * side, kept_rows});
    above_ = Image<float>({width + 2 * side, kept_rows});
    costs_known_ = Image<std::uint8_t>({width / costed_together + 1, kept_rows});
  }
  moved.clear();
  disagreeing.clear();
  far_above.assign(static_cast<std::size_t>(width), 1);
}

void VoteBlock::clear(int first, int last) {
  for (int row = first; row < last; ++row) {
    std::fill_n(coordinates(row), flags_.width(), nothing);
  }
}

void VoteBlock::forget_vote() {
  for (const auto& [at, coordinate, pixel_flags] : moved) {
    coordinates(at.row)[at.column] = coordinate;
    flags(at.row)[at.column] = pixel_flags;
  }
  moved.clear();
}

}  // namespace slipstream
