#include "cloud/depth_rows.h"

#include <algorithm>
#include <limits>
#include <type_traits>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "cloud/depth_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "base/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

constexpr std::size_t word_pixels = 64;

/// The bits of a mask of at most 16 lanes, the first lane in the lowest.
template <class Tag>
HWY_INLINE std::uint64_t bits_of(Tag d, hn::Mask<Tag> mask) {
  std::conditional_t<(hn::MaxLanes(Tag()) > 8), std::uint16_t, std::uint8_t> bits = 0;
  hn::StoreMaskBits(d, mask, reinterpret_cast<std::uint8_t*>(&bits));
  return bits;
}

/// Stores the bits of the vector that begins at pixel `i` of a little-endian word.
HWY_INLINE void store_bits(FloatMask mask, std::size_t i, std::uint64_t& word) {
  auto* const bytes = reinterpret_cast<std::uint8_t*>(&word) + i / 8;
  if constexpr (hn::MaxLanes(FloatTag()) >= 8) {
    hn::StoreMaskBits(FloatTag(), mask, bytes);
  } else {  // a part of a byte
    const std::uint64_t part = bits_of(FloatTag(), mask) << i % 8;
    *bytes = static_cast<std::uint8_t>((i % 8 == 0 ? 0 : *bytes) | part);
  }
}

HWY_INLINE FloatMask is_trusted(const TrustStage& trust, Floats x, Floats y, Floats z,
                                Floats modulation) {
  const FloatTag d;
  const auto set = [&](float value) SLIPSTREAM_STEP { return hn::Set(d, value); };

  // Both sides of the condition in TrustStage.
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

  // 1. Which pixels have points; in a word without any, all other bits are 0.
  std::uint64_t points = 0;
  for (std::size_t i = 0; i < word_pixels; i += hn::Lanes(d)) {
    points |= bits_of(d, hn::Gt(hn::LoadU(d, row.here + i), hn::Zero(d))) << i;
  }

  row.point[word] = points;
  if (points == 0) {
    for (std::uint64_t* const words :
         {row.trusted, row.to_right, row.to_below, row.bent_along, row.bent_across}) {
      words[word] = 0;
    }
    return;
  }

  // 2. Steps to the neighbours, against limits that grow with the depth.
  const Floats step = hn::Set(d, limits.step), bend = hn::Set(d, limits.bend);
  const bool trusts_all = row.modulation == nullptr;
  if (trusts_all) row.trusted[word] = points;

  for (std::size_t i = 0; i < word_pixels; i += hn::Lanes(d)) {
    const Floats z = hn::LoadU(d, row.here + i);
    const Floats from_left = hn::Sub(z, hn::LoadU(d, row.here + i - 1));
    const Floats to_right = hn::Sub(hn::LoadU(d, row.here + i + 1), z);
    const Floats from_above = hn::Sub(z, hn::LoadU(d, row.above + i));
    const Floats to_below = hn::Sub(hn::LoadU(d, row.below + i), z);

    const Floats largest_step = hn::Mul(step, z), largest_bend = hn::Mul(bend, z);
    store_bits(hn::Le(hn::Abs(to_right), largest_step), i, row.to_right[word]);
    store_bits(hn::Le(hn::Abs(to_below), largest_step), i, row.to_below[word]);

    store_bits(hn::Gt(hn::Abs(hn::Sub(to_right, from_left)), largest_bend), i,
               row.bent_along[word]);
    store_bits(hn::Gt(hn::Abs(hn::Sub(to_below, from_above)), largest_bend), i,
               row.bent_across[word]);

    if (trusts_all) continue;
    store_bits(is_trusted(trust, hn::LoadU(d, row.x + i), hn::LoadU(d, row.y + i), z,
                          hn::LoadU(d, row.modulation + i)),
               i, row.trusted[word]);
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

      // NaN beyond the row, and before these pixels the depth of the one on their left.
      to->fill(std::numeric_limits<float>::quiet_NaN());
      std::copy_n(*from + first, count, to->data() + 1);
      if (from == &row.here) to->front() = *(*from + first - 1);
      *from = to++->data() + 1;
    }
  }

  DepthRow row;
  std::array<std::array<float, word_pixels + 2>, 6> copies;
};

void CompareDepths(const DepthLimits& limits_of_cloud, const TrustStage& trust_of_cloud,
                   const DepthRow& row) {
  // Local copies stay in registers: no store can alias them.
  const DepthLimits limits = limits_of_cloud;
  const TrustStage trust = trust_of_cloud;

  DepthRow at = row;
  const auto width = static_cast<std::size_t>(row.width);
  std::size_t first = 0;

  for (; first + word_pixels <= width; first += word_pixels) {
    compare_word(limits, trust, at, first / word_pixels);
    for (const float** pixels : inputs(at)) {
      if (*pixels != nullptr) *pixels += word_pixels;
    }
  }

  if (first < width) compare_word(limits, trust, LastPixels(row, first).row, first / word_pixels);
}

using WordTag = hn::ScalableTag<std::uint64_t>;
using Words = hn::Vec<WordTag>;

template <class... More>
HWY_INLINE Words all(Words bits, More... more) {
  ((bits = hn::And(bits, more)), ...);
  return bits;
}

template <class... More>
HWY_INLINE Words any(Words bits, More... more) {
  ((bits = hn::Or(bits, more)), ...);
  return bits;
}

HWY_INLINE Words words(const std::uint64_t* at) {
  return hn::LoadU(WordTag(), at);
}

/// The bits of the pixels `distance` before or after in the row.
template <int distance = 1>
HWY_INLINE Words before(const std::uint64_t* at) {
  return hn::Or(hn::ShiftLeft<distance>(words(at)), hn::ShiftRight<64 - distance>(words(at - 1)));
}
template <int distance = 1>
HWY_INLINE Words after(const std::uint64_t* at) {
  return hn::Or(hn::ShiftRight<distance>(words(at)), hn::ShiftLeft<64 - distance>(words(at + 1)));
}

/// Links and bends along the rows of a block between trusted points, from the word before it on.
struct LinksAlong {
  static constexpr std::size_t words_of_ends = 1 + 2 * hn::MaxLanes(WordTag());

  explicit LinksAlong(const RelationWords& of) {
    const WordTag d;

    for (std::size_t i = 0; i < block_words + 2; i += hn::Lanes(d)) {
      const std::uint64_t* const trusted = of.trusted + i - 1;
      const Words both = hn::And(words(trusted), after(trusted));

      hn::StoreU(hn::And(words(of.to_right + i - 1), both), d, linked.data() + i);
      hn::StoreU(all(words(of.bent_along + i - 1), both, before(trusted)), d, bent.data() + i);
    }
  }

  std::array<std::uint64_t, block_words + words_of_ends> linked, bent;
};

std::uint64_t FindEvidence(const RelationWords& of, const EvidenceWords& to) {
  const WordTag d;
  const LinksAlong along(of);

  std::uint64_t found = 0;
  for (std::size_t i = 0; i < block_words; i += hn::Lanes(d)) {
    const auto row = [&](const std::uint64_t* plane, std::ptrdiff_t down)
                         SLIPSTREAM_STEP { return words(plane + i + down * of.stride); };

    const std::uint64_t* const points = of.trusted + i;
    const std::uint64_t* const linked = along.linked.data() + 1 + i;
    const std::uint64_t* const bent = along.bent.data() + 1 + i;
    const Words here = words(points), above = row(of.trusted, -1), below = row(of.trusted, 1);
    // Pairs of this row and the next, of the one above it and this, and those beyond.
    const Words both = hn::And(here, below), both_up = hn::And(above, here);
    const Words both_1 = hn::And(below, row(of.trusted, 2));
    const Words both_up_1 = hn::And(row(of.trusted, -2), above);

    // Links to the four neighbours, and over two pixels in each direction.
    const Words right = words(linked), left = before(linked);
    const Words down = hn::And(row(of.to_below, 0), both);
    const Words up = hn::And(row(of.to_below, -1), both_up);
    const Words right_2 = hn::And(right, after(linked)), left_2 = hn::And(left, before<2>(linked));
    const Words down_2 = all(down, row(of.to_below, 1), both_1);
    const Words up_2 = all(up, row(of.to_below, -2), both_up_1);

    // Bends need three points in a column.
    const Words bent_across = all(row(of.bent_across, 0), both, both_up);
    const Words bent_above = all(row(of.bent_across, -1), both_up, both_up_1);
    const Words bent_below = all(row(of.bent_across, 1), both, both_1);

    const Words mixed =
        hn::And(here, any(hn::AndNot(right_2, before(bent)), hn::AndNot(left_2, after(bent)),
                          hn::AndNot(down_2, bent_above), hn::AndNot(up_2, bent_below)));

    const Words at_edge =
        hn::And(here, any(hn::AndNot(right, after(points)), hn::AndNot(left, before(points)),
                          hn::AndNot(down, below), hn::AndNot(up, above)));

    // Thin unless the surface goes on for several pixels in both the row and the column.
    const Words wide = any(all(right_2, after<2>(linked), after<3>(linked)),
                           all(left_2, before<3>(linked), before<4>(linked)));
    const Words high = hn::Or(hn::And(down_2, row(of.to_below, 2)), up_2);
    const Words thin = hn::AndNot(hn::And(wide, high), here);

    const Words bent_in_both = all(right, left, down, up, words(bent), bent_across);
    const Words surrounded = all(before(points), after(points), above, below);
    const Words outlier =
        hn::And(here, hn::Or(bent_in_both, hn::AndNot(any(right, left, down, up), surrounded)));

    const Words untrusted = hn::AndNot(here, words(of.point + i));
    hn::StoreU(mixed, d, to.mixed + i);
    hn::StoreU(at_edge, d, to.at_edge + i);
    hn::StoreU(thin, d, to.thin + i);
    hn::StoreU(outlier, d, to.outlier + i);

    const Words evidence = any(mixed, at_edge, thin, outlier, untrusted);
    found |= bits_of(d, hn::Ne(evidence, hn::Zero(d))) << i;
  }

  return found;
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(CompareDepths);
HWY_EXPORT(FindEvidence);

void compare_depths(const DepthLimits& limits, const TrustStage& trust, const DepthRow& row) {
  HWY_DYNAMIC_DISPATCH(CompareDepths)(limits, trust, row);
}

std::uint64_t find_evidence(const RelationWords& relations, const EvidenceWords& evidence) {
  return HWY_DYNAMIC_DISPATCH(FindEvidence)(relations, evidence);
}

}  // namespace slipstream
#endif
