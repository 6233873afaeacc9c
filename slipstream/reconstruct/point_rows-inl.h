// Coordinate to point. Included once for each vector target, see fused_rows.cpp.
#if defined(SLIPSTREAM_RECONSTRUCT_POINT_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SLIPSTREAM_RECONSTRUCT_POINT_ROWS_INL_H_
#undef SLIPSTREAM_RECONSTRUCT_POINT_ROWS_INL_H_
#else
#define SLIPSTREAM_RECONSTRUCT_POINT_ROWS_INL_H_
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <limits>

#include <hwy/highway.h>

#include "slipstream/reconstruct/fused_rows.h"
#include "slipstream/reconstruct/sinusoid_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

using FloatMask = hn::Mask<FloatTag>;

HWY_INLINE Floats linear(const PointStage::Linear& c, Floats E_x, Floats E_y) {
  const FloatTag d;
  return hn::MulAdd(hn::Set(d, c[0]), E_x, hn::MulAdd(hn::Set(d, c[1]), E_y, hn::Set(d, c[2])));
}

/// PlanePolynomial, its coefficients from the last to the first.
template <int degree>
HWY_INLINE Floats plane_polynomial(const float* coefficients, Floats p, Floats q) {
  const FloatTag d;
  const float* c = coefficients;
  Floats sum = hn::Set(d, *c++);
  for (int i = degree - 1; i >= 0; --i) {
    Floats inner = hn::Set(d, *c++);
    for (int j = degree - i - 1; j >= 0; --j) inner = hn::MulAdd(inner, q, hn::Set(d, *c++));
    sum = hn::MulAdd(sum, p, inner);
  }
  return sum;
}

HWY_INLINE Floats edge_polynomial(const std::array<float, 6>& edge, Floats p) {
  const FloatTag d;
  Floats sum = hn::Set(d, edge.back());
  for (std::size_t i = edge.size() - 1; i > 0; --i) {
    sum = hn::MulAdd(sum, p, hn::Set(d, edge[i - 1]));
  }
  return sum;
}

/// Where the point of a pixel is, and the three reasons why it may have none.
struct RayPoints {
  Floats E_x, E_y, z;
  FloatMask exists, in_field, in_range;
};

/// StripeGeometry::operator().
template <int lens_degree>
HWY_INLINE RayPoints points_on_rays(const PointStage& stage, const PointRow& row, std::size_t i,
                                    Floats y) {
  const FloatTag d;
  const Floats E_x = hn::LoadU(d, row.E_x + i), E_y = hn::LoadU(d, row.E_y + i);
  const Floats p = hn::MulAdd(y, hn::Set(d, stage.unit_scale), hn::Set(d, stage.unit_offset));
  const Floats g = linear(stage.facing, E_x, E_y);
  const Floats place =
      hn::MulAdd(p, linear(stage.place_slope, E_x, E_y), linear(stage.place_constant, E_x, E_y));
  const Floats q = quotient(place, g);
  Floats w = y;
  if constexpr (lens_degree > 0) {
    w = hn::Add(y, plane_polynomial<lens_degree>(stage.lens.data(), p, q));
  }
  const Floats numerator =
      hn::MulSub(w, hn::Set(d, stage.depth_offset), hn::Set(d, stage.coordinate_offset));
  const Floats denominator =
      hn::NegMulAdd(w, linear(stage.depth, E_x, E_y), linear(stage.coordinate, E_x, E_y));
  const Floats z = quotient(numerator, denominator);

  const Floats largest = hn::Set(d, std::numeric_limits<float>::max());
  const FloatMask before_camera = hn::And(hn::Gt(z, hn::Zero(d)), hn::Le(z, largest));
  const FloatMask before_projector = hn::Gt(hn::Mul(denominator, g), hn::Zero(d));
  FloatMask in_field =
      hn::And(hn::Gt(q, hn::Set(d, stage.inner_low)), hn::Lt(q, hn::Set(d, stage.inner_high)));
  if (HWY_UNLIKELY(!hn::AllTrue(d, in_field))) {
    in_field = hn::And(hn::Ge(q, edge_polynomial(stage.low_edge, p)),
                       hn::Le(q, edge_polynomial(stage.high_edge, p)));
  }
  if (stage.may_leave_field) {
    in_field = hn::And(in_field, hn::And(hn::Ge(y, hn::Set(d, stage.least_coordinate)),
                                         hn::Le(y, hn::Set(d, stage.largest_coordinate))));
  }
  return {E_x,
          E_y,
          z,
          hn::And(before_camera, before_projector),
          in_field,
          hn::And(hn::Ge(z, hn::Set(d, stage.nearest)), hn::Le(z, hn::Set(d, stage.farthest)))};
}

template <std::size_t terms>
HWY_INLINE Floats polynomial(const float* coefficients, Floats x) {
  const FloatTag d;
  Floats sum = hn::Set(d, coefficients[terms - 1]);
  for (std::size_t k = terms - 1; k > 0; --k) {
    sum = hn::MulAdd(sum, x, hn::Set(d, coefficients[k - 1]));
  }
  return sum;
}

/// The coefficients of a row's block, quadratic between the knots.
HWY_INLINE void mix(const RayBlocks::Row& blocks, std::size_t block, RayBlocks::Block& mixed) {
  const FloatTag d;
  const auto knot = [&](std::size_t k)
                        HWY_ATTR { return blocks.knots[k][block].coefficients.data(); };
  const auto weight = [&](std::size_t k) HWY_ATTR { return hn::Set(d, blocks.weights[k]); };
  for (std::size_t i = 0; i < mixed.coefficients.size(); i += hn::Lanes(d)) {
    Floats sum = hn::Mul(weight(0), hn::Load(d, knot(0) + i));
    sum = hn::MulAdd(weight(1), hn::Load(d, knot(1) + i), sum);
    sum = hn::MulAdd(weight(2), hn::Load(d, knot(2) + i), sum);
    hn::Store(sum, d, mixed.coefficients.data() + i);
  }
}

/// Of a block that is described at p; `t` as in RayBlocks.
HWY_INLINE RayPoints points_of_block(const PointStage& stage, const RayBlocks::Block& block,
                                     Floats t, Floats p, FloatMask described) {
  using Block = RayBlocks::Block;
  constexpr int first_slope = RayBlocks::constants;
  constexpr int first_bend = first_slope + RayBlocks::slopes;
  const FloatTag d;
  const float* c = block.coefficients.data();
  const Floats bend = polynomial<RayBlocks::bends>(c + first_bend, p);
  const Floats slope = hn::MulAdd(bend, t, polynomial<RayBlocks::slopes>(c + first_slope, p));
  const Floats inverse = hn::MulAdd(slope, t, polynomial<RayBlocks::constants>(c, p));
  const Floats z = quotient(hn::Set(d, 1.0F), inverse);
  return {polynomial<3>(c + Block::E_x, t),
          polynomial<3>(c + Block::E_y, t),
          z,
          hn::Gt(inverse, hn::Zero(d)),
          described,
          hn::And(hn::Ge(z, hn::Set(d, stage.nearest)), hn::Le(z, hn::Set(d, stage.farthest)))};
}

/// A block's coefficients in one row, and where they hold.
struct MixedBlock {
  RayBlocks::Block block;
  RayBlocks::Range described;
};

/// By the block where it describes all pixels that are not dark, else one by one.
template <int lens_degree>
HWY_INLINE RayPoints points_of(const PointStage& stage, const PointRow& row, std::size_t i,
                               const MixedBlock& mixed, Floats t, Floats y, FloatMask dark) {
  const FloatTag d;
  if (HWY_LIKELY(mixed.described.least < mixed.described.largest)) {
    const Floats p = hn::MulAdd(y, hn::Set(d, stage.unit_scale), hn::Set(d, stage.unit_offset));
    const FloatMask described = hn::And(hn::Ge(p, hn::Set(d, mixed.described.least)),
                                        hn::Le(p, hn::Set(d, mixed.described.largest)));
    if (HWY_LIKELY(hn::AllTrue(d, hn::Or(described, dark)))) {
      return points_of_block(stage, mixed.block, t, p, described);
    }
  }
  return points_on_rays<lens_degree>(stage, row, i, y);
}

/// Lanes that have at least as many agreeing neighbours as they need, see FringeOrderConsensus.
class Neighbourhood {
 public:
  HWY_INLINE Neighbourhood(const ConsensusStage& stage, const PointRow& row)
      : half_fringe_(stage.half_fringe),
        needed_(stage.fewest_neighbours),
        needed_if_doubtful_(stage.fewest_if_doubtful),
        row_(row) {}

  HWY_INLINE Floats coordinate(std::size_t i) const {
    return hn::LoadU(FloatTag(), row_.coordinate + i);
  }

  HWY_INLINE FloatMask confirms(std::size_t i, Floats y, Ints flags) const {
    const FloatTag d;
    const IntTag di;
    const auto doubtful =
        hn::Ne(hn::And(flags, hn::Set(di, PixelFlag::doubtful_order)), hn::Zero(di));
    const Ints needed =
        hn::IfThenElse(doubtful, hn::Set(di, needed_if_doubtful_), hn::Set(di, needed_));
    // In a surface the row's own neighbours suffice; masks are -1 as integers.
    Ints missing = hn::Add(
        needed, hn::Add(agreeing(row_.coordinate, i - 1, y), agreeing(row_.coordinate, i + 1, y)));
    const auto dark = hn::Ne(hn::And(flags, hn::Set(di, PixelFlag::dark)), hn::Zero(di));
    const auto settled = hn::Or(dark, hn::Lt(missing, hn::Set(di, 1)));
    if (HWY_UNLIKELY(!hn::AllTrue(di, settled))) {
      for (const float* other : {row_.above, row_.below}) {
        for (std::size_t j = i - 1; j != i + 2; ++j) {
          missing = hn::Add(missing, agreeing(other, j, y));
        }
      }
    }
    return hn::RebindMask(d, hn::Lt(missing, hn::Set(di, 1)));
  }

 private:
  HWY_INLINE Ints agreeing(const float* others, std::size_t i, Floats y) const {
    const FloatTag d;
    const Floats other = hn::LoadU(d, others + i);
    return hn::VecFromMask(IntTag(), hn::RebindMask(IntTag(), hn::Lt(hn::Abs(hn::Sub(other, y)),
                                                                     hn::Set(d, half_fringe_))));
  }

  float half_fringe_;
  int needed_, needed_if_doubtful_;
  const PointRow& row_;
};

/// One frequency leaves nothing to confirm; its coordinate is made of the turn here.
class Alone {
 public:
  HWY_INLINE Alone(const CoordinateStage& stage, const PointRow& row)
      : in_field_(stage), row_(row) {}

  HWY_INLINE Floats coordinate(std::size_t i) const {
    return in_field_(hn::LoadU(FloatTag(), row_.coordinate + i));
  }
  HWY_INLINE FloatMask confirms(std::size_t, Floats, Ints) const {
    return hn::FirstN(FloatTag(), hn::Lanes(FloatTag()));
  }

 private:
  FieldPlacer in_field_;
  const PointRow& row_;
};

HWY_INLINE Ints reason_unless(FloatMask good, Ints otherwise, Validity reason) {
  const IntTag di;
  return hn::IfThenElse(hn::RebindMask(di, good), otherwise,
                        hn::Set(di, static_cast<std::int32_t>(reason)));
}

HWY_INLINE void store_validity(Ints reasons, Validity* validity) {
  const hn::Rebind<std::uint8_t, IntTag> bytes;
  hn::StoreU(hn::DemoteTo(bytes, reasons), bytes, reinterpret_cast<std::uint8_t*>(validity));
}

template <bool only_depth>
HWY_INLINE void store_points(const PointRow& row, std::size_t i, Floats E_x, Floats E_y, Floats z) {
  store(z, row.z + i, row.past_cache);
  if constexpr (!only_depth) {
    store(hn::Mul(E_x, z), row.x + i, row.past_cache);
    store(hn::Mul(E_y, z), row.y + i, row.past_cache);
  }
}

/// The first reason in the order of Validity wins.
HWY_INLINE Ints reasons(const RayPoints& points, FloatMask confirmed, Ints flags) {
  const FloatTag d;
  const IntTag di;
  const auto without = [&](PixelFlag flag) HWY_ATTR {
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

/// The vector of pixels from `i` on.
template <int lens_degree, bool only_depth, class Source>
HWY_INLINE void point_vector(const PointStage& stage, const Source& source, const PointRow& row,
                             std::size_t i, const MixedBlock& mixed, Floats t) {
  const FloatTag d;
  const IntTag di;
  const Floats nan = hn::Set(d, std::numeric_limits<float>::quiet_NaN());
  const Ints flags = hn::LoadU(di, row.flags + i);
  const auto dark = hn::Ne(hn::And(flags, hn::Set(di, PixelFlag::dark)), hn::Zero(di));
  if (hn::AllTrue(di, dark)) {
    store_points<only_depth>(row, i, nan, nan, nan);
    return store_validity(hn::Set(di, static_cast<std::int32_t>(Validity::too_dark)),
                          row.validity + i);
  }
  const Floats y = source.coordinate(i);
  const FloatMask confirmed = source.confirms(i, y, flags);
  const RayPoints points =
      points_of<lens_degree>(stage, row, i, mixed, t, y, hn::RebindMask(d, dark));
  const FloatMask unflagged = hn::RebindMask(
      d, hn::Eq(hn::And(flags, hn::Set(di, PixelFlag::dark | PixelFlag::saturated)), hn::Zero(di)));
  const FloatMask good = hn::And(hn::And(unflagged, confirmed),
                                 hn::And(points.exists, hn::And(points.in_field, points.in_range)));
  if (HWY_LIKELY(hn::AllTrue(d, good))) {
    store_points<only_depth>(row, i, points.E_x, points.E_y, points.z);
    return store_validity(hn::Zero(di), row.validity + i);
  }
  store_points<only_depth>(row, i, points.E_x, points.E_y, hn::IfThenElse(good, points.z, nan));
  store_validity(reasons(points, confirmed, flags), row.validity + i);
}

template <int lens_degree, bool only_depth, class Source>
HWY_INLINE void point_vectors(const PointStage& stage, const Source& source, const PointRow& row) {
  const FloatTag d;
  const auto width = static_cast<std::size_t>(row.width);
  constexpr std::size_t block_width = RayBlocks::width;
  constexpr float half = 0.5F * block_width;
  const Floats first_t =
      hn::Mul(hn::Add(hn::Iota(d, 0), hn::Set(d, 0.5F - half)), hn::Set(d, 1 / half));
  MixedBlock mixed;
  for (std::size_t b = 0; b * block_width < width; ++b) {
    const std::size_t first = std::min(b * block_width, width - block_width);
    if (row.blocks.described != nullptr) {
      mixed.described = row.blocks.described[b];
      mix(row.blocks, b, mixed.block);
    }
    for (std::size_t j = 0; j < block_width; j += hn::Lanes(d)) {
      const Floats t = hn::Add(first_t, hn::Set(d, static_cast<float>(j) / half));
      point_vector<lens_degree, only_depth>(stage, source, row, first + j, mixed, t);
    }
  }
}

template <int lens_degree, class Source>
HWY_INLINE void point_row_of_degree(const PointStage& stage, const Source& source,
                                    const PointRow& row) {
  if (row.x == nullptr) return point_vectors<lens_degree, true>(stage, source, row);
  return point_vectors<lens_degree, false>(stage, source, row);
}

template <class Source>
HWY_INLINE void point_row_with(const PointStage& stage, const Source& source, const PointRow& row) {
  switch (stage.lens_degree) {
    case 0:
      return point_row_of_degree<0>(stage, source, row);
    case 3:
      return point_row_of_degree<3>(stage, source, row);
    case 5:
      return point_row_of_degree<5>(stage, source, row);
    case 7:
      return point_row_of_degree<7>(stage, source, row);
    default:
      return point_row_of_degree<9>(stage, source, row);
  }
}

void PointRowAlone(const PointStage& stage, const CoordinateStage& coordinate,
                   const PointRow& row) {
  point_row_with(stage, Alone(coordinate, row), row);
}

void PointRowConfirmed(const PointStage& stage, const ConsensusStage& consensus,
                       const PointRow& row) {
  point_row_with(stage, Neighbourhood(consensus, row), row);
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
