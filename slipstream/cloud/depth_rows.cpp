#include "slipstream/cloud/depth_rows.h"

#include <algorithm>
#include <cstddef>
#include <limits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slipstream/cloud/depth_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "slipstream/base/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

constexpr std::size_t word_pixels = 64;

/// Stores the bits of the vector that begins at pixel `i` of a little-endian word.
HWY_INLINE void store_bits(FloatMask mask, std::size_t i, std::uint64_t& word) {
  auto* const bytes = reinterpret_cast<std::uint8_t*>(&word) + i / 8;
  if constexpr (hn::MaxLanes(FloatTag()) >= 8) {
    hn::StoreMaskBits(FloatTag(), mask, bytes);
  } else {  // a part of a byte
    std::array<std::uint8_t, 8> part{};
    hn::StoreMaskBits(FloatTag(), mask, part.data());
    *bytes = static_cast<std::uint8_t>((i % 8 == 0 ? 0 : *bytes) | part[0] << i % 8);
  }
}

HWY_INLINE FloatMask is_trusted(const TrustStage& trust, Floats x, Floats y, Floats z,
                                Floats modulation) {
  const FloatTag d;
  const auto set = [&](float value) SLIPSTREAM_STEP { return hn::Set(d, value); };
  const auto& q = trust.projector_depth;
  const auto& w = trust.parallax;
  const Floats depth =
      hn::MulAdd(set(q[0]), x, hn::MulAdd(set(q[1]), y, hn::MulAdd(set(q[2]), z, set(q[3]))));
  const Floats parallax =
      hn::Abs(hn::MulAdd(set(w[0]), x, hn::MulAdd(set(w[1]), y, hn::Mul(set(w[2]), z))));
  const Floats weight = hn::MulAdd(set(trust.by_depth), z, set(trust.constant));
  return hn::Le(hn::Mul(hn::Mul(depth, depth), weight), hn::Mul(modulation, parallax));
}

/// Compares 64 pixels from `row.here` on, into word `word`.
HWY_INLINE void compare_word(const DepthLimits& limits, const TrustStage& trust,
                             const DepthRow& row, std::size_t word) {
  const FloatTag d;
  const Floats step = hn::Set(d, limits.step), bend = hn::Set(d, limits.bend);
  for (std::size_t i = 0; i < word_pixels; i += hn::Lanes(d)) {
    const Floats z = hn::LoadU(d, row.here + i);
    const Floats from_left = hn::Sub(z, hn::LoadU(d, row.here + i - 1));
    const Floats to_right = hn::Sub(hn::LoadU(d, row.here + i + 1), z);
    const Floats from_above = hn::Sub(z, hn::LoadU(d, row.above + i));
    const Floats to_below = hn::Sub(hn::LoadU(d, row.below + i), z);
    const Floats largest_step = hn::Mul(step, z), largest_bend = hn::Mul(bend, z);
    const FloatMask is_point = hn::Gt(z, hn::Zero(d));
    store_bits(is_point, i, row.point[word]);
    store_bits(hn::Le(hn::Abs(to_right), largest_step), i, row.to_right[word]);
    store_bits(hn::Le(hn::Abs(to_below), largest_step), i, row.to_below[word]);
    store_bits(hn::Gt(hn::Abs(hn::Sub(to_right, from_left)), largest_bend), i,
               row.bent_along[word]);
    store_bits(hn::Gt(hn::Abs(hn::Sub(to_below, from_above)), largest_bend), i,
               row.bent_across[word]);
    const bool all = row.modulation == nullptr;
    const FloatMask trusted =
        all ? is_point
            : is_trusted(trust, hn::LoadU(d, row.x + i), hn::LoadU(d, row.y + i), z,
                         hn::LoadU(d, row.modulation + i));
    store_bits(trusted, i, row.trusted[word]);
  }
}

/// The inputs of the comparison.
HWY_INLINE std::array<const float**, 6> inputs(DepthRow& row) {
  return {&row.above, &row.here, &row.below, &row.x, &row.y, &row.modulation};
}

/// The rest of a row whose width is not a multiple of 64, padded with NaN.
struct LastPixels {
  LastPixels(const DepthRow& whole, std::size_t first) : row(whole) {
    const std::size_t count = static_cast<std::size_t>(row.width) - first;
    auto to = copies.begin();
    for (const float** from : inputs(row)) {
      if (*from == nullptr) continue;
      to->fill(std::numeric_limits<float>::quiet_NaN());
      std::copy_n(*from + first, count, to->data() + 1);
      if (from == &row.here) to->front() = *(*from + first - 1);
      *from = to++->data() + 1;
    }
  }

  DepthRow row;
  std::array<std::array<float, word_pixels + 2>, 6> copies;
};

void CompareDepths(const DepthLimits& limits, const TrustStage& trust, const DepthRow& row) {
  const auto width = static_cast<std::size_t>(row.width);
  DepthRow at = row;
  std::size_t first = 0;
  for (; first + word_pixels <= width; first += word_pixels) {
    compare_word(limits, trust, at, first / word_pixels);
    for (const float** pixels : inputs(at)) {
      if (*pixels != nullptr) *pixels += word_pixels;
    }
  }
  if (first < width) {
    compare_word(limits, trust, LastPixels(row, first).row, first / word_pixels);
  }
  const std::uint64_t last = std::uint64_t{1} << (width - 1) % word_pixels;
  row.to_right[(width - 1) / word_pixels] &= ~last;
  row.bent_along[(width - 1) / word_pixels] &= ~last;
  row.bent_along[0] &= ~std::uint64_t{1};
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(CompareDepths);

void compare_depths(const DepthLimits& limits, const TrustStage& trust, const DepthRow& row) {
  HWY_DYNAMIC_DISPATCH(CompareDepths)(limits, trust, row);
}

}  // namespace slipstream
#endif
