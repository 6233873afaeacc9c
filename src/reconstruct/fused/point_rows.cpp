#include "reconstruct/fused/point_rows.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <tuple>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "reconstruct/fused/point_rows.cpp"
#include <hwy/foreach_target.h>

#include "base/vectors-inl.h"
#include "reconstruct/fused/ray_points-inl.h"
#include "reconstruct/fused/sinusoid_sums-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

template <class Source>
HWY_INLINE void row_on_rays(const PointStage& stage, const Source& source, const PointRow& row) {
  const VectorOnRays vector = vector_on_rays_for(stage.lens_degree);

  for_each_vector(row.width, [&](std::size_t i) SLIPSTREAM_STEP {
    const Ints flags = hn::LoadU(IntTag(), row.flags + i);
    if (hn::AllTrue(FloatTag(), is_dark(flags))) return store_dark(row, i);

    vector(stage, row, i, source.coordinate(i), source.confirms(i, flags), flags);
  });
}

/// Coefficients of several neighbouring blocks in one row. All are computed before any is used:
/// reading single numbers from a vector just written is slow.
struct MixedBlocks {
  static constexpr std::size_t most = 40;
  static constexpr std::size_t terms = std::tuple_size_v<decltype(RayBlocks::Block::coefficients)>;

  /// Interpolates quadratically between the knots.
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
        hn::Store(sum, d, coefficients.data() + b * terms + i);
      }
    }
  }

  alignas(64) std::array<float, most * terms> coefficients;  ///< block after block
};

/// Neighbouring vectors of a row, starting at `pixel`. `coefficients` and `described` point to
/// their first block; the next blocks follow. `t` as in RayBlocks.
template <std::size_t count>
class BlockParts {
 public:
  static constexpr std::size_t vectors_of_block = RayBlocks::width / hn::MaxLanes(FloatTag());

  HWY_INLINE BlockParts(std::size_t pixel, std::size_t first_vector, const float* coefficients,
                        const RayBlocks::Range* described)
      : pixel_(pixel), coefficients_(coefficients), described_(described) {
    const FloatTag d;
    constexpr float half = 0.5F * RayBlocks::width;

    const Floats column = hn::Iota(d, 0.5F - half);
    each<count>([&](std::size_t k) SLIPSTREAM_STEP {
      const std::size_t start = (first_vector + k) % vectors_of_block * hn::Lanes(d);
      t[k] = hn::Mul(hn::Add(column, hn::Set(d, static_cast<float>(start))), hn::Set(d, 1 / half));
    });
  }

  [[nodiscard]] HWY_INLINE std::size_t pixel(std::size_t k) const {
    return pixel_ + k * hn::Lanes(FloatTag());
  }

  [[nodiscard]] HWY_INLINE Floats coefficient(std::size_t k, std::size_t i) const {
    return hn::Set(FloatTag(), coefficients_[k / vectors_of_block * MixedBlocks::terms + i]);
  }

  [[nodiscard]] HWY_INLINE FloatMask describe(std::size_t k, Floats p) const {
    const FloatTag d;
    const RayBlocks::Range& range = described_[k / vectors_of_block];

    return hn::And(hn::Ge(p, hn::Set(d, range.least)), hn::Le(p, hn::Set(d, range.largest)));
  }

  Several<count> t;

 private:
  std::size_t pixel_;
  const float* coefficients_;
  const RayBlocks::Range* described_;
};

/// Polynomial in p of each vector; its coefficients start at `first`.
template <std::size_t first, std::size_t terms, std::size_t count>
HWY_INLINE Several<count> polynomials(const BlockParts<count>& parts, const Several<count>& p) {
  Several<count> sum;

  // Horner's scheme, one step for all vectors at a time.
  each<count>([&](std::size_t k)
                  SLIPSTREAM_STEP { sum[k] = parts.coefficient(k, first + terms - 1); });
  each<terms - 1>([&](std::size_t i) SLIPSTREAM_STEP {
    each<count>([&](std::size_t k) SLIPSTREAM_STEP {
      sum[k] = hn::MulAdd(sum[k], p[k], parts.coefficient(k, first + terms - 2 - i));
    });
  });

  return sum;
}

/// Z of the pixels, at p.
template <std::size_t count>
HWY_INLINE Several<count> depths(const BlockParts<count>& parts, const Several<count>& p) {
  using Blocks = RayBlocks;
  constexpr std::size_t slopes = Blocks::constants, bends = slopes + Blocks::slopes,
                        twist = bends + Blocks::bends;
  static_assert(Blocks::twists == 1);

  // 1 / Z as a cubic in t, each of its coefficients a polynomial in p. Horner's scheme in t takes
  // each as soon as it is known, so that few vectors are kept.
  const auto add_next = [&](const Several<count>& sum, Several<count> next) SLIPSTREAM_STEP {
    each<count>([&](std::size_t k)
                    SLIPSTREAM_STEP { next[k] = hn::MulAdd(sum[k], parts.t[k], next[k]); });
    return next;
  };

  Several<count> inverse;
  each<count>([&](std::size_t k) SLIPSTREAM_STEP { inverse[k] = parts.coefficient(k, twist); });
  inverse = add_next(inverse, polynomials<bends, Blocks::bends>(parts, p));
  inverse = add_next(inverse, polynomials<slopes, Blocks::slopes>(parts, p));
  inverse = add_next(inverse, polynomials<0, Blocks::constants>(parts, p));

  Several<count> z;
  const Floats one = hn::Set(FloatTag(), 1.0F);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP { z[k] = quotient(one, inverse[k]); });

  return z;
}

/// E_x or E_y; coefficients start at `first`.
template <std::size_t count>
HWY_INLINE Floats ray_direction(const BlockParts<count>& parts, std::size_t k, std::size_t first) {
  static_assert(RayBlocks::ray_terms == 4);
  Floats sum = parts.coefficient(k, first + 3);
  sum = hn::MulAdd(sum, parts.t[k], parts.coefficient(k, first + 2));
  sum = hn::MulAdd(sum, parts.t[k], parts.coefficient(k, first + 1));
  return hn::MulAdd(sum, parts.t[k], parts.coefficient(k, first));
}

HWY_INLINE void fetch_ahead(const PointRow& row, std::size_t i) {
  fetch_ahead(row.z + i, row.past_cache);
  if (row.x == nullptr) return;
  fetch_ahead(row.x + i, row.past_cache);
  fetch_ahead(row.y + i, row.past_cache);
}

template <std::size_t count>
HWY_INLINE void store_depths(const PointRow& row, bool past_cache, const BlockParts<count>& parts,
                             const Several<count>& z) {
  each<count>([&](std::size_t k)
                  SLIPSTREAM_STEP { store(z[k], row.z + parts.pixel(k), past_cache); });
  if (row.x == nullptr) return;
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    const Floats E_x = ray_direction(parts, k, RayBlocks::Block::E_x);
    store(hn::Mul(E_x, z[k]), row.x + parts.pixel(k), past_cache);
    const Floats E_y = ray_direction(parts, k, RayBlocks::Block::E_y);
    store(hn::Mul(E_y, z[k]), row.y + parts.pixel(k), past_cache);
  });
}

/// Stores vectors in which every pixel has a point.
template <std::size_t count>
HWY_INLINE void store_all(const PointRow& row, bool past_cache, const BlockParts<count>& parts,
                          const Several<count>& z) {
  store_depths(row, past_cache, parts, z);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    store_validity(hn::Zero(IntTag()), row.validity + parts.pixel(k));
  });
}

/// Stores vectors in which every pixel has a point or is dark, as at the edges of shadows.
template <std::size_t count>
HWY_INLINE void store_where_not_dark(const PointRow& row, const BlockParts<count>& parts,
                                     const Several<count, FloatMask>& dark, Several<count> z) {
  static_assert(static_cast<int>(Validity::valid) == 0);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    z[k] = hn::IfThenElse(dark[k], nans(), z[k]);
    const auto reason = hn::Set(IntTag(), static_cast<std::int32_t>(Validity::too_dark));
    store_validity(hn::IfThenElseZero(hn::RebindMask(IntTag(), dark[k]), reason),
                   row.validity + parts.pixel(k));
  });
  store_depths(row, row.past_cache, parts, z);
}

/// Stores a vector in which some pixels have no point.
template <std::size_t count, class Source>
HWY_NOINLINE void vector_with_reasons(const PointStage& stage, const Source& source,
                                      const PointRow& row, const BlockParts<count>& parts,
                                      std::size_t k, Floats p, Floats z) {
  const FloatTag d;
  const std::size_t i = parts.pixel(k);
  const Ints flags = hn::LoadU(IntTag(), row.flags + i);
  const FloatMask described = parts.describe(k, p);
  const FloatMask confirmed = source.confirms(i, flags);

  // A lit pixel outside its block's range: compute the whole vector exactly.
  if (!hn::AllTrue(d, hn::Or(described, is_dark(flags)))) {
    return vector_on_rays_for(stage.lens_degree)(stage, row, i, source.coordinate(i), confirmed,
                                                 flags);
  }

  // Within the range every point exists and lies in the field.
  const RayPoints points{ray_direction(parts, k, RayBlocks::Block::E_x),
                         ray_direction(parts, k, RayBlocks::Block::E_y),
                         z,
                         described,
                         described,
                         within_limits(stage, z)};
  store_vector(row, i, points, confirmed, flags);
}

/// Several vectors together: by their blocks if every pixel has a point, else one by one.
template <std::size_t count, class Source>
HWY_INLINE void point_vectors(const PointStage& stage, const Source& source, const PointRow& row,
                              const BlockParts<count>& parts) {
  const FloatTag d;

  Several<count> p;
  Several<count, FloatMask> good;
  FloatMask all = hn::FirstN(d, hn::Lanes(d));

  // 1. Which pixels the blocks describe and their neighbours confirm.
  fetch_ahead(row.validity + parts.pixel(0), false);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    fetch_ahead(row, parts.pixel(k));
    p[k] = source.unit_coordinate(parts.pixel(k));
    good[k] = parts.describe(k, p[k]);
  });

  source.keep_trusted(row, parts.pixel(0), good);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP { all = hn::And(all, good[k]); });

  // 2. Mostly all of them: compute and store. The branch makes `past_cache` a constant.
  if (HWY_LIKELY(hn::AllTrue(d, all) && !stage.limits_depth)) {
    const Several<count> z = depths(parts, p);
    if (row.past_cache) return store_all(row, true, parts, z);
    return store_all(row, false, parts, z);
  }

  // 3. Otherwise find out whether the rest is only dark.
  FloatMask all_dark = hn::FirstN(d, hn::Lanes(d)), all_good_or_dark = all_dark;
  Several<count, FloatMask> dark;
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    dark[k] = is_dark(hn::LoadU(IntTag(), row.flags + parts.pixel(k)));
    all_dark = hn::And(all_dark, dark[k]);
    all_good_or_dark = hn::And(all_good_or_dark, hn::Or(dark[k], good[k]));
  });

  if (hn::AllTrue(d, all_dark)) {
    return each<count>([&](std::size_t k) SLIPSTREAM_STEP { store_dark(row, parts.pixel(k)); });
  }

  // 4. Depths, which may have limits.
  const Several<count> z = depths(parts, p);
  if (stage.limits_depth) {
    each<count>([&](std::size_t k) SLIPSTREAM_STEP {
      all_good_or_dark = hn::And(all_good_or_dark, hn::Or(dark[k], within_limits(stage, z[k])));
    });
  }

  if (HWY_LIKELY(hn::AllTrue(d, all_good_or_dark)))
    return store_where_not_dark(row, parts, dark, z);

  // 5. Some lit pixel has no point: vector by vector, with the reasons.
  const PointRow row_copy = row;  // copies, so that the originals stay in registers
  const BlockParts<count> parts_copy = parts;
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    vector_with_reasons(stage, source, row_copy, parts_copy, k, p[k], z[k]);
  });
}

/// Computes `pixels` pixels of consecutive blocks, from `pixel` on.
template <std::size_t most, class Source>
HWY_INLINE void point_blocks(const PointStage& stage, const Source& source, const PointRow& row,
                             std::size_t pixel, std::size_t pixels, const float* coefficients,
                             const RayBlocks::Range* described) {
  for_each_group<most>(pixels, [&]<std::size_t count>(Together<count>,
                                                      std::size_t i) SLIPSTREAM_STEP {
    const std::size_t vector = i / hn::Lanes(FloatTag()), block = i / RayBlocks::width;
    point_vectors(stage, source, row,
                  BlockParts<count>(pixel + i, vector, coefficients + block * MixedBlocks::terms,
                                    described + block));
  });
}

/// Computes `count` blocks from `first` on. The last of a row may overlap the one before it.
template <class Source>
HWY_INLINE void point_part(const PointStage& stage, const Source& source, const PointRow& row,
                           const float* coefficients, std::size_t first, std::size_t count) {
  constexpr std::size_t width = RayBlocks::width;
  const std::size_t pixel = first * width;
  const std::size_t whole = std::min(count, (static_cast<std::size_t>(row.width) - pixel) / width);
  const RayBlocks::Range* const described = row.blocks.described + first;

  // With AVX2 one block at a time, so that each of its coefficients is copied to a vector once.
  constexpr std::size_t most = HWY_MAX_BYTES == 32 ? 4 : few_at_once;
  point_blocks<most>(stage, source, row, pixel, whole * width, coefficients, described);
  if (whole == count) return;

  // The last block is placed so that it ends with the row.
  const int last = RayBlocks::first_column(static_cast<int>(first + whole), row.width);
  point_blocks<1>(stage, source, row, static_cast<std::size_t>(last), width,
                  coefficients + whole * MixedBlocks::terms, described + whole);
}

template <class Source>
HWY_INLINE void point_row(const PointStage& stage, const Source& source, const PointRow& row) {
  if (row.blocks.described == nullptr) return row_on_rays(stage, source, row);
  const auto width = static_cast<std::size_t>(row.width);
  const std::size_t blocks = (width + RayBlocks::width - 1) / RayBlocks::width;

  MixedBlocks mixed;
  for (std::size_t first = 0; first < blocks; first += MixedBlocks::most) {
    const std::size_t count = std::min(MixedBlocks::most, blocks - first);
    mixed.mix(row.blocks, first, count);
    point_part(stage, source, row, mixed.coefficients.data(), first, count);
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

void NumberRow(const DepthScale& scale, int width, const float* z, std::uint16_t* numbers) {
  const FloatTag d;
  const hn::Rebind<std::uint16_t, FloatTag> words;
  const Floats offset = hn::Set(d, scale.offset), per_mm = hn::Set(d, 1 / scale.scale);

  for_each_vector(width, [&](std::size_t i) SLIPSTREAM_STEP {
    const Floats number =
        hn::MulAdd(hn::Sub(hn::LoadU(d, z + i), offset), per_mm, hn::Set(d, 0.5F));

    // Numbers begin at 1; 0 means no depth. With the 0.5 added above, the conversion rounds.
    const auto in_range =
        hn::And(hn::Ge(number, hn::Set(d, 1.0F)), hn::Lt(number, hn::Set(d, 65536.0F)));
    const Ints whole = hn::ConvertTo(IntTag(), hn::IfThenElseZero(in_range, number));
    hn::StoreU(hn::DemoteTo(words, whole), words, numbers + i);
  });
}

/// Stores a whole vector if there is room. Compresses in a register: compressing into memory takes
/// a hundred cycles on some processors.
HWY_INLINE void pack(const float* from, FloatMask points, std::size_t count, float* to,
                     bool has_room) {
  const FloatTag d;
  const Floats values = hn::Compress(hn::LoadU(d, from), points);
  if (HWY_LIKELY(has_room)) return hn::StoreU(values, d, to);

  // At the end of the room: write only the values.
  HWY_ALIGN float packed[HWY_MAX_BYTES / sizeof(float)];  // NOLINT(modernize-avoid-c-arrays)
  hn::StoreU(values, d, packed);
  std::copy_n(static_cast<const float*>(packed), count, to);
}

std::size_t PackRow(int width, const PointValues<const float>& from, const PointValues<float>& to,
                    std::size_t room) {
  const FloatTag d;
  const std::size_t pixels = static_cast<std::size_t>(width), lanes = hn::Lanes(d);

  std::size_t packed = 0;
  for (std::size_t next = 0; next < pixels; next += lanes) {
    const std::size_t i = std::min(next, pixels - lanes);  // the last overlaps the one before it

    // Lanes already packed with the vector before do not count.
    const FloatMask is_new = hn::Ge(hn::Iota(d, 0), hn::Set(d, static_cast<float>(next - i)));
    const FloatMask points = hn::AndNot(hn::IsNaN(hn::LoadU(d, from.z + i)), is_new);
    const std::size_t count = hn::CountTrue(d, points);

    const bool has_room = packed + lanes <= room;
    pack(from.x + i, points, count, to.x + packed, has_room);
    pack(from.y + i, points, count, to.y + packed, has_room);
    pack(from.z + i, points, count, to.z + packed, has_room);
    pack(from.intensity + i, points, count, to.intensity + packed, has_room);

    packed += count;
  }

  return packed;
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(PointRowAlone);
HWY_EXPORT(PointRowConfirmed);
HWY_EXPORT(NumberRow);
HWY_EXPORT(PackRow);

void point_row(const PointStage& stage, const CoordinateStage& coordinate, const PointRow& row) {
  HWY_DYNAMIC_DISPATCH(PointRowAlone)(stage, coordinate, row);
}

void point_row(const PointStage& stage, const ConsensusStage& consensus, const PointRow& row) {
  HWY_DYNAMIC_DISPATCH(PointRowConfirmed)(stage, consensus, row);
}

void number_row(const DepthScale& scale, int width, const float* z, std::uint16_t* numbers) {
  HWY_DYNAMIC_DISPATCH(NumberRow)(scale, width, z, numbers);
}

std::size_t pack_row(int width, const PointValues<const float>& from, const PointValues<float>& to,
                     std::size_t room) {
  return HWY_DYNAMIC_DISPATCH(PackRow)(width, from, to, room);
}

void flush_past_cache() {
  hwy::FlushStream();
}

}  // namespace slipstream
#endif
