#include "slipstream/reconstruct/point_rows.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <tuple>

#include "slipstream/reconstruct/disabled_targets-inl.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slipstream/reconstruct/point_rows.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "slipstream/reconstruct/ray_points-inl.h"
#include "slipstream/reconstruct/sinusoid_turns-inl.h"
#include "slipstream/reconstruct/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

HWY_INLINE Ints reason_unless(FloatMask good, Ints otherwise, Validity reason) {
  const IntTag di;
  return hn::IfThenElse(hn::RebindMask(di, good), otherwise,
                        hn::Set(di, static_cast<std::int32_t>(reason)));
}

HWY_INLINE void store_validity(Ints reasons, Validity* validity) {
  const hn::Rebind<std::uint8_t, IntTag> bytes;
  hn::StoreU(hn::DemoteTo(bytes, reasons), bytes, reinterpret_cast<std::uint8_t*>(validity));
}

/// With `past_cache` in place of that of the row, so that it need not be asked for each vector.
HWY_INLINE void store_points(const PointRow& row, bool past_cache, std::size_t i, Floats E_x,
                             Floats E_y, Floats z) {
  store(z, row.z + i, past_cache);
  if (row.x != nullptr) {
    store(hn::Mul(E_x, z), row.x + i, past_cache);
    store(hn::Mul(E_y, z), row.y + i, past_cache);
  }
}

/// The first reason in the order of Validity wins.
HWY_INLINE Ints reasons(const RayPoints& points, FloatMask confirmed, Ints flags) {
  const FloatTag d;
  const IntTag di;
  const auto without = [&](PixelFlag flag) SLIPSTREAM_STEP {
    return hn::RebindMask(d, hn::Eq(hn::And(flags, hn::Set(di, flag)), hn::Zero(di)));
  };
  Ints reason = hn::Zero(di);
  reason = reason_unless(points.in_range, reason, Validity::out_of_range);
  reason = reason_unless(points.in_field, reason, Validity::outside_field);
  reason = reason_unless(points.exists, reason, Validity::no_point);
  reason = reason_unless(confirmed, reason, Validity::doubtful_order);
  reason = reason_unless(without(PixelFlag::saturated), reason, Validity::saturated);
  return reason_unless(without(PixelFlag::dark), reason, Validity::too_dark);
}

/// A vector of pixels that are all dark.
HWY_INLINE void store_dark(const PointRow& row, std::size_t i) {
  const Floats nan = hn::Set(FloatTag(), std::numeric_limits<float>::quiet_NaN());
  store_points(row, row.past_cache, i, nan, nan, nan);
  store_validity(hn::Set(IntTag(), static_cast<std::int32_t>(Validity::too_dark)),
                 row.validity + i);
}

/// The points of a vector of pixels, some of which may have none.
HWY_INLINE void store_vector(const PointRow& row, std::size_t i, const RayPoints& points,
                             FloatMask good, FloatMask confirmed, Ints flags) {
  const FloatTag d;
  const Floats nan = hn::Set(d, std::numeric_limits<float>::quiet_NaN());
  const Floats z = hn::IfThenElse(good, points.z, nan);
  store_points(row, row.past_cache, i, points.E_x, points.E_y, z);
  if (hn::AllTrue(d, good)) return store_validity(hn::Zero(IntTag()), row.validity + i);
  store_validity(reasons(points, confirmed, flags), row.validity + i);
}

HWY_INLINE FloatMask is_unflagged(Ints flags) {
  const IntTag di;
  const Ints flagged = hn::And(flags, hn::Set(di, PixelFlag::dark | PixelFlag::saturated));
  return hn::RebindMask(FloatTag(), hn::Eq(flagged, hn::Zero(di)));
}

/// One vector without its block.
template <int lens_degree>
HWY_NOINLINE void vector_on_rays(const PointStage& stage, const PointRow& row, std::size_t i,
                                 Floats y, FloatMask confirmed, Ints flags) {
  const RayPoints points = points_on_rays<lens_degree>(stage, row, i, y);
  const FloatMask good = hn::And(hn::And(is_unflagged(flags), confirmed),
                                 hn::And(points.exists, hn::And(points.in_field, points.in_range)));
  store_vector(row, i, points, good, confirmed, flags);
}

using VectorOnRays = void (*)(const PointStage&, const PointRow&, std::size_t, Floats, FloatMask,
                              Ints);

/// For the degree of PointStage::lens.
HWY_INLINE VectorOnRays vector_on_rays_for(int lens_degree) {
  switch (lens_degree) {
    case 0:
      return vector_on_rays<0>;
    case 3:
      return vector_on_rays<3>;
    case 5:
      return vector_on_rays<5>;
    case 7:
      return vector_on_rays<7>;
    default:
      return vector_on_rays<9>;
  }
}

template <class Source>
HWY_INLINE void row_on_rays(const PointStage& stage, const Source& source, const PointRow& row) {
  const VectorOnRays vector = vector_on_rays_for(stage.lens_degree);
  for_each_vector(row.width, [&](std::size_t i) SLIPSTREAM_STEP {
    const Ints flags = hn::LoadU(IntTag(), row.flags + i);
    if (hn::AllTrue(FloatTag(), is_dark(flags))) return store_dark(row, i);
    vector(stage, row, i, source.coordinate(i), source.confirms(i, flags), flags);
  });
}

/// The coefficients of some neighbouring blocks in one row. They stand ready before any is used:
/// to read single numbers out of a vector just written takes long.
class MixedBlocks {
 public:
  static constexpr std::size_t most = 32;

  /// Quadratic between the knots.
  HWY_INLINE void mix(const RayBlocks::Row& blocks, std::size_t first, std::size_t count) {
    const FloatTag d;
    const Floats w0 = hn::Set(d, blocks.weights[0]), w1 = hn::Set(d, blocks.weights[1]),
                 w2 = hn::Set(d, blocks.weights[2]);
    for (std::size_t b = 0; b < count; ++b) {
      const auto knot = [&](std::size_t k) SLIPSTREAM_STEP {
        return blocks.knots[k][first + b].coefficients.data();
      };
      for (std::size_t i = 0; i < terms; i += hn::Lanes(d)) {
        Floats sum = hn::Mul(w0, hn::Load(d, knot(0) + i));
        sum = hn::MulAdd(w1, hn::Load(d, knot(1) + i), sum);
        sum = hn::MulAdd(w2, hn::Load(d, knot(2) + i), sum);
        hn::Store(sum, d, coefficients_.data() + b * terms + i);
      }
    }
  }

  [[nodiscard]] HWY_INLINE const float* operator[](std::size_t block) const {
    return coefficients_.data() + block * terms;
  }

 private:
  static constexpr std::size_t terms = std::tuple_size_v<decltype(RayBlocks::Block::coefficients)>;
  alignas(64) std::array<float, most * terms> coefficients_;
};

/// A vector of pixels of a block.
struct BlockPart {
  std::size_t pixel;
  const float* coefficients;
  RayBlocks::Range described;
};

/// Some vectors of a row; `t` as in RayBlocks.
template <std::size_t count>
struct BlockParts {
  std::array<BlockPart, count> part;
  Several<count> t;

  HWY_INLINE BlockParts() {}

  [[nodiscard]] HWY_INLINE Floats coefficient(std::size_t k, std::size_t i) const {
    return hn::Set(FloatTag(), part[k].coefficients[i]);
  }
};

/// A polynomial in p of each vector, one step at a time: its coefficients are those from `first`
/// on.
template <std::size_t first, std::size_t terms, std::size_t count>
HWY_INLINE Several<count> polynomials(const BlockParts<count>& parts, const Several<count>& p) {
  Several<count> sum;
  each<count>([&](std::size_t k)
                  SLIPSTREAM_STEP { sum[k] = parts.coefficient(k, first + terms - 1); });
  each<terms - 1>([&](std::size_t i) SLIPSTREAM_STEP {
    each<count>([&](std::size_t k) SLIPSTREAM_STEP {
      sum[k] = hn::MulAdd(sum[k], p[k], parts.coefficient(k, first + terms - 2 - i));
    });
  });
  return sum;
}

/// 1/Z of the pixels at p.
template <std::size_t count>
HWY_INLINE Several<count> inverse_depths(const BlockParts<count>& parts, const Several<count>& p) {
  using Blocks = RayBlocks;
  constexpr std::size_t slopes = Blocks::constants, bends = slopes + Blocks::slopes;
  const Several<count> bend = polynomials<bends, Blocks::bends>(parts, p);
  Several<count> slope = polynomials<slopes, Blocks::slopes>(parts, p);
  Several<count> inverse = polynomials<0, Blocks::constants>(parts, p);
  each<count>([&](std::size_t k)
                  SLIPSTREAM_STEP { slope[k] = hn::MulAdd(bend[k], parts.t[k], slope[k]); });
  each<count>([&](std::size_t k)
                  SLIPSTREAM_STEP { inverse[k] = hn::MulAdd(slope[k], parts.t[k], inverse[k]); });
  return inverse;
}

/// E_x or E_y, whose coefficients begin at `first`.
template <std::size_t count>
HWY_INLINE Floats ray_direction(const BlockParts<count>& parts, std::size_t k, std::size_t first) {
  const Floats slope =
      hn::MulAdd(parts.coefficient(k, first + 2), parts.t[k], parts.coefficient(k, first + 1));
  return hn::MulAdd(slope, parts.t[k], parts.coefficient(k, first));
}

/// Vectors of which every pixel has its point.
template <std::size_t count>
HWY_INLINE void store_all(const PointRow& row, bool past_cache, const BlockParts<count>& parts,
                          const Several<count>& z) {
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    const std::size_t i = parts.part[k].pixel;
    store_points(row, past_cache, i, ray_direction(parts, k, RayBlocks::Block::E_x),
                 ray_direction(parts, k, RayBlocks::Block::E_y), z[k]);
    store_validity(hn::Zero(IntTag()), row.validity + i);
  });
}

/// Vectors of which every pixel that is not dark has its point, as at the edges of shadows.
template <std::size_t count>
HWY_INLINE void store_where_not_dark(const PointRow& row, const BlockParts<count>& parts,
                                     const Several<count>& z, const Several<count, Ints>& flags) {
  const Floats nan = hn::Set(FloatTag(), std::numeric_limits<float>::quiet_NaN());
  static_assert(static_cast<int>(Validity::valid) == 0 &&
                static_cast<int>(Validity::too_dark) == PixelFlag::dark);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    const std::size_t i = parts.part[k].pixel;
    store_points(row, row.past_cache, i, ray_direction(parts, k, RayBlocks::Block::E_x),
                 ray_direction(parts, k, RayBlocks::Block::E_y),
                 hn::IfThenElse(is_dark(flags[k]), nan, z[k]));
    store_validity(hn::And(flags[k], hn::Set(IntTag(), PixelFlag::dark)), row.validity + i);
  });
}

/// Some vectors together: those without a fault by their blocks, the others one by one.
template <std::size_t count, class Source>
HWY_INLINE void point_vectors(const PointStage& stage, const Source& source, const PointRow& row,
                              const BlockParts<count>& parts) {
  const FloatTag d;
  const IntTag di;
  Several<count, Ints> flags;
  Ints common = hn::Set(di, PixelFlag::dark);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    flags[k] = hn::LoadU(di, row.flags + parts.part[k].pixel);
    common = hn::And(common, flags[k]);
  });
  if (hn::AllTrue(d, is_dark(common))) {
    return each<count>([&](std::size_t k)
                           SLIPSTREAM_STEP { store_dark(row, parts.part[k].pixel); });
  }
  Several<count> p, z;
  Several<count, FloatMask> described, confirmed, in_range, good;
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    const BlockPart& part = parts.part[k];
    p[k] = source.unit_coordinate(part.pixel);
    confirmed[k] = source.confirms(part.pixel, flags[k]);
    described[k] = hn::And(hn::Ge(p[k], hn::Set(d, part.described.least)),
                           hn::Le(p[k], hn::Set(d, part.described.largest)));
  });
  const Several<count> inverse = inverse_depths<count>(parts, p);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP { z[k] = reciprocal(inverse[k]); });

  FloatMask all = hn::FirstN(d, hn::Lanes(d)), all_good_or_dark = all;
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    in_range[k] =
        hn::And(hn::Ge(z[k], hn::Set(d, stage.nearest)), hn::Le(z[k], hn::Set(d, stage.farthest)));
    good[k] =
        hn::And(hn::And(is_unflagged(flags[k]), confirmed[k]), hn::And(described[k], in_range[k]));
    all = hn::And(all, good[k]);
    all_good_or_dark = hn::And(all_good_or_dark, hn::Or(good[k], is_dark(flags[k])));
  });
  if (HWY_LIKELY(hn::AllTrue(d, all))) {
    if (row.past_cache) return store_all(row, true, parts, z);
    return store_all(row, false, parts, z);
  }
  if (HWY_LIKELY(hn::AllTrue(d, all_good_or_dark))) {
    return store_where_not_dark(row, parts, z, flags);
  }
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    const std::size_t i = parts.part[k].pixel;
    if (!hn::AllTrue(d, hn::Or(described[k], is_dark(flags[k])))) {
      const PointRow seen = row;  // the original stays in registers if nobody else sees it
      return vector_on_rays_for(stage.lens_degree)(stage, seen, i, source.coordinate(i),
                                                   confirmed[k], flags[k]);
    }
    const FloatMask exists = hn::Gt(inverse[k], hn::Zero(d));
    store_vector(
        row, i,
        {ray_direction(parts, k, RayBlocks::Block::E_x),
         ray_direction(parts, k, RayBlocks::Block::E_y), z[k], exists, described[k], in_range[k]},
        good[k], confirmed[k], flags[k]);
  });
}

/// Where the blocks of a part of a row stand, whose coefficients are mixed.
class RowPart {
 public:
  HWY_INLINE RowPart(const PointRow& row, const MixedBlocks& mixed, int first, std::size_t blocks)
      : row_(row), mixed_(mixed), first_(first), blocks_(blocks) {
    const FloatTag d;
    first_t_ = hn::Mul(hn::Add(hn::Iota(d, 0), hn::Set(d, 0.5F - half)), hn::Set(d, 1 / half));
  }

  [[nodiscard]] HWY_INLINE std::size_t vectors() const { return blocks_ * vectors_of_block; }

  /// From vector `next` on.
  template <std::size_t count>
  [[nodiscard]] HWY_INLINE BlockParts<count> at(std::size_t next) const {
    const FloatTag d;
    BlockParts<count> parts;
    each<count>([&](std::size_t k) SLIPSTREAM_STEP {
      const std::size_t block = (next + k) / vectors_of_block;
      const std::size_t start = (next + k) % vectors_of_block * hn::Lanes(d);
      const int b = first_ + static_cast<int>(block);
      parts.part[k] = {static_cast<std::size_t>(RayBlocks::first_column(b, row_.width)) + start,
                       mixed_[block], row_.blocks.described[b]};
      parts.t[k] = hn::Add(first_t_, hn::Set(d, static_cast<float>(start) / half));
    });
    return parts;
  }

 private:
  static constexpr float half = 0.5F * RayBlocks::width;
  static constexpr std::size_t vectors_of_block = RayBlocks::width / hn::MaxLanes(FloatTag());

  const PointRow& row_;
  const MixedBlocks& mixed_;
  int first_;
  std::size_t blocks_;
  Floats first_t_;
};

template <class Source>
HWY_INLINE void point_part(const PointStage& stage, const Source& source, const PointRow& row,
                           const RowPart& part) {
  std::size_t next = 0;
  for (; next + at_once <= part.vectors(); next += at_once) {
    point_vectors(stage, source, row, part.template at<at_once>(next));
  }
  for (; next < part.vectors(); ++next) {
    point_vectors(stage, source, row, part.template at<1>(next));
  }
}

template <class Source>
HWY_INLINE void point_row(const PointStage& stage, const Source& source, const PointRow& row) {
  if (row.blocks.described == nullptr) {
    return row_on_rays(stage, source, row);
  }
  const int blocks = (row.width + RayBlocks::width - 1) / RayBlocks::width;
  MixedBlocks mixed;
  for (int first = 0; first < blocks; first += static_cast<int>(MixedBlocks::most)) {
    const std::size_t count = std::min(MixedBlocks::most, static_cast<std::size_t>(blocks - first));
    mixed.mix(row.blocks, static_cast<std::size_t>(first), count);
    point_part(stage, source, row, RowPart(row, mixed, first, count));
  }
}

void PointRowAlone(const PointStage& stage, const CoordinateStage& coordinate,
                   const PointRow& row) {
  const PointRow local = row;
  point_row(stage, Alone(stage, coordinate, row), local);
}

void PointRowConfirmed(const PointStage& stage, const ConsensusStage& consensus,
                       const PointRow& row) {
  const PointRow local = row;
  point_row(stage, Neighbourhood(stage, consensus, row), local);
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(PointRowAlone);
HWY_EXPORT(PointRowConfirmed);

void point_row(const PointStage& stage, const CoordinateStage& coordinate, const PointRow& row) {
  HWY_DYNAMIC_DISPATCH(PointRowAlone)(stage, coordinate, row);
}

void point_row(const PointStage& stage, const ConsensusStage& consensus, const PointRow& row) {
  HWY_DYNAMIC_DISPATCH(PointRowConfirmed)(stage, consensus, row);
}

void flush_past_cache() {
  hwy::FlushStream();
}

}  // namespace slipstream
#endif
