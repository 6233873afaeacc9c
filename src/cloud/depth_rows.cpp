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

/// A vector of words of a block's row, with the rows around it. `down`: rows below that row.
class PlaceInBlock {
 public:
  HWY_INLINE PlaceInBlock(const RelationWords& of, const LinksAlong& along, std::size_t i)
      : points(of.trusted + i),
        linked(along.linked.data() + 1 + i),
        bent(along.bent.data() + 1 + i),
        of_(of),
        i_(i) {}

  HWY_INLINE Words points_in(std::ptrdiff_t down) const { return row(of_.trusted, down); }
  HWY_INLINE Words to_below(std::ptrdiff_t down) const { return row(of_.to_below, down); }

  /// Points that have another one below them.
  HWY_INLINE Words pairs(std::ptrdiff_t down) const {
    return hn::And(points_in(down), points_in(down + 1));
  }

  /// Points with a link to the one below them.
  HWY_INLINE Words linked_down(std::ptrdiff_t down) const {
    return hn::And(to_below(down), pairs(down));
  }

  /// Bends of the columns, which need three points.
  HWY_INLINE Words bent_across(std::ptrdiff_t down) const {
    return all(row(of_.bent_across, down), pairs(down), pairs(down - 1));
  }

  const std::uint64_t *points, *linked, *bent;  ///< this row's; linked and bent along it

 private:
  HWY_INLINE Words row(const std::uint64_t* plane, std::ptrdiff_t down) const {
    return words(plane + i_ + down * of_.stride);
  }

  const RelationWords& of_;
  std::size_t i_;
};

/// Links to the four neighbours, and over two pixels in each direction.
struct LinksAround {
  Words right, left, down, up, right_2, left_2, down_2, up_2;
};

HWY_INLINE LinksAround links_around(const PlaceInBlock& at) {
  const Words right = words(at.linked), left = before(at.linked);
  const Words down = at.linked_down(0), up = at.linked_down(-1);

  return {right,
          left,
          down,
          up,
          hn::And(right, after(at.linked)),
          hn::And(left, before<2>(at.linked)),
          hn::And(down, at.linked_down(1)),
          hn::And(up, at.linked_down(-2))};
}

/// EvidenceWords::mixed: beside a bend, and without links over two pixels on the other side.
HWY_INLINE Words mixed_points(const PlaceInBlock& at, const LinksAround& links) {
  return hn::And(
      at.points_in(0),
      any(hn::AndNot(links.right_2, before(at.bent)), hn::AndNot(links.left_2, after(at.bent)),
          hn::AndNot(links.down_2, at.bent_across(-1)), hn::AndNot(links.up_2, at.bent_across(1))));
}

/// EvidenceWords::at_edge.
HWY_INLINE Words points_at_edge(const PlaceInBlock& at, const LinksAround& links) {
  return hn::And(
      at.points_in(0),
      any(hn::AndNot(links.right, after(at.points)), hn::AndNot(links.left, before(at.points)),
          hn::AndNot(links.down, at.points_in(1)), hn::AndNot(links.up, at.points_in(-1))));
}

/// EvidenceWords::thin: unless the surface goes on for several pixels in both the row and the
/// column.
HWY_INLINE Words thin_points(const PlaceInBlock& at, const LinksAround& links) {
  const Words wide = any(all(links.right_2, after<2>(at.linked), after<3>(at.linked)),
                         all(links.left_2, before<3>(at.linked), before<4>(at.linked)));
  const Words high = hn::Or(hn::And(links.down_2, at.to_below(2)), links.up_2);

  return hn::AndNot(hn::And(wide, high), at.points_in(0));
}

/// EvidenceWords::outlier.
HWY_INLINE Words outliers(const PlaceInBlock& at, const LinksAround& links) {
  const Words linked_to_all = all(links.right, links.left, links.down, links.up);
  const Words linked_to_any = any(links.right, links.left, links.down, links.up);

  const Words bent_in_both = all(linked_to_all, words(at.bent), at.bent_across(0));
  const Words surrounded =
      all(before(at.points), after(at.points), at.points_in(-1), at.points_in(1));

  return hn::And(at.points_in(0), hn::Or(bent_in_both, hn::AndNot(linked_to_any, surrounded)));
}

std::uint64_t FindEvidence(const RelationWords& of, const EvidenceWords& to) {
  const WordTag d;
  const LinksAlong along(of);

  std::uint64_t found = 0;
  for (std::size_t i = 0; i < block_words; i += hn::Lanes(d)) {
    const PlaceInBlock at(of, along, i);
    const LinksAround links = links_around(at);

    const Words mixed = mixed_points(at, links), at_edge = points_at_edge(at, links);
    const Words thin = thin_points(at, links), outlier = outliers(at, links);
    const Words untrusted = hn::AndNot(at.points_in(0), words(of.point + i));

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
