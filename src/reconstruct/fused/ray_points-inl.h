// Coordinates to points, by ray tables and lens polynomial. Included once per vector target.
#if defined(SLIPSTREAM_KERNELS_RAY_POINTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SLIPSTREAM_KERNELS_RAY_POINTS_INL_H_
#undef SLIPSTREAM_KERNELS_RAY_POINTS_INL_H_
#else
#define SLIPSTREAM_KERNELS_RAY_POINTS_INL_H_
#endif

#include <array>
#include <cstdint>
#include <limits>

#include <hwy/highway.h>

#include "base/vectors-inl.h"
#include "reconstruct/fused/point_rows.h"
#include "reconstruct/fused/sinusoid_sums-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {
template <class Terms>
HWY_INLINE Floats linear(const Terms& c, Floats E_x, Floats E_y) {
  const FloatTag d;
  return hn::MulAdd(hn::Set(d, c[0]), E_x, hn::MulAdd(hn::Set(d, c[1]), E_y, hn::Set(d, c[2])));
}

/// PlanePolynomial, coefficients from the last to the first.
template <int degree>
HWY_INLINE Floats plane_polynomial(const float* coefficients, Floats p, Floats q) {
  const FloatTag d;
  const float* c = coefficients;
  Floats sum = hn::Set(d, *c++);

  // Horner's scheme in p, whose coefficients are polynomials in q.
  for (int i = degree - 1; i >= 0; --i) {
    Floats inner = hn::Set(d, *c++);
    for (int j = degree - i - 1; j >= 0; --j) inner = hn::MulAdd(inner, q, hn::Set(d, *c++));
    sum = hn::MulAdd(sum, p, inner);
  }

  return sum;
}

/// A direction (a, b, 1), and its derivatives by the undistorted coordinate.
struct RayDirection {
  Floats a, b, da, db;
};

/// Bends directions as the lens of SolvedLens does. With s = r^2:
///   R = (1 + k1 s + k2 s^2 + k3 s^3) / (1 + k4 s + k5 s^2 + k6 s^3),
///   a bends to a (R + t_a a + t_b b) + s (u_a + v_a s),
///   b bends to b (R + t_a a + t_b b) + s (u_b + v_b s).
/// k1 to k6 are its radial terms, t its tangential ones; u and v add its thin prism.
class LensBend {
 public:
  HWY_INLINE explicit LensBend(const SolvedLens& lens)
      : lens_(lens), t_a_(k(7)), t_b_(k(8)), u_a_(k(9)), v_a_(k(10)), u_b_(k(11)), v_b_(k(12)) {}

  /// `s`: becomes r^2 of the direction.
  HWY_INLINE RayDirection bent(const RayDirection& from, Floats& s) const {
    const Floats one = all(1), two = all(2);
    const Floats a = from.a, b = from.b, da = from.da, db = from.db;

    // Derivatives by w begin with d, but dR is by r^2.
    const Floats ds = two * (a * da + b * db);
    s = a * a + b * b;

    // Radial terms: numerator and denominator of R, and R's derivative by s.
    const Floats below = one / (one + s * (k(4) + s * (k(5) + s * k(6))));
    const Floats R = below * (one + s * (k(1) + s * (k(2) + s * k(3))));
    const Floats dR = below * (k(1) + s * (two * k(2) + all(3) * s * k(3)) -
                               R * (k(4) + s * (two * k(5) + all(3) * s * k(6))));

    const Floats scale = R + t_a_ * a + t_b_ * b, dscale = dR * ds + t_a_ * da + t_b_ * db;
    const Floats bent_a = a * scale + s * (u_a_ + v_a_ * s);
    const Floats bent_b = b * scale + s * (u_b_ + v_b_ * s);
    const Floats dbent_a = da * scale + a * dscale + ds * (u_a_ + two * v_a_ * s);
    const Floats dbent_b = db * scale + b * dscale + ds * (u_b_ + two * v_b_ * s);

    return {bent_a, bent_b, dbent_a, dbent_b};
  }

 private:
  static HWY_INLINE Floats all(float c) { return hn::Set(FloatTag(), c); }
  HWY_INLINE Floats k(int i) const { return all(lens_.bend(i - 1)); }

  const SolvedLens& lens_;
  Floats t_a_, t_b_, u_a_, v_a_, u_b_, v_b_;
};

/// The undistorted coordinate of the point lit at y on a ray with q = start + w rise, see
/// SolvedLens. Newton's method from w: mostly two steps.
HWY_INLINE Floats solved(const SolvedLens& lens, Floats y, Floats w, Floats start, Floats rise,
                         FloatMask& in_field) {
  const auto all = [](float c) SLIPSTREAM_STEP { return hn::Set(FloatTag(), c); };
  const Floats settled = all(1e-4F);  // the next change is about the square of this one
  const LensBend lens_bend(lens);

  const auto row = [&](int i) SLIPSTREAM_STEP {  // its product with the bent direction is 0 at y
    return all(lens.image(0, i)) - y * all(lens.image(2, i));
  };

  // Derivatives of the direction by w.
  const Floats da = all(lens.direction(0, 0)) + all(lens.direction(0, 1)) * rise;
  const Floats db = all(lens.direction(1, 0)) + all(lens.direction(1, 1)) * rise;

  RayDirection bent{y, y, y, y};
  Floats s = y, change = y;  // s is r^2
  for (int step = 0; step < 12; ++step) {
    // The direction of w on the epipolar line, bent by the lens.
    const Floats q = w * rise + start;
    const Floats a = linear(lens.direction.row(0), w, q), b = linear(lens.direction.row(1), w, q);
    bent = lens_bend.bent({a, b, da, db}, s);

    // Newton's step towards the decoded coordinate y.
    const Floats error = row(0) * bent.a + row(1) * bent.b + row(2);
    change = error / (row(0) * bent.da + row(1) * bent.db);
    w = w - change;
    if (hn::AllFalse(FloatTag(), hn::Gt(hn::Abs(change), settled))) break;
  }

  // The point lies in the field if its position along the stripe does, Newton's method has
  // settled, and the ray is not so far out that the lens model turns back.
  const Floats place = linear(lens.image.row(1), bent.a, bent.b);
  in_field =
      hn::And(hn::Le(hn::Abs(place), linear(lens.image.row(2), bent.a, bent.b)),
              hn::And(hn::Le(hn::Abs(change), settled), hn::Le(s, all(lens.largest_square))));

  return w;
}

HWY_INLINE Floats edge_polynomial(const EdgeTerms& edge, Floats p) {
  const FloatTag d;
  Floats sum = hn::Set(d, edge.back());

  // Horner's scheme, highest power first.
  for (std::size_t i = edge.size() - 1; i > 0; --i) {
    sum = hn::MulAdd(sum, p, hn::Set(d, edge[i - 1]));
  }

  return sum;
}

/// Points of a vector of pixels, and the three conditions that a point must meet.
struct RayPoints {
  Floats E_x, E_y, z;
  FloatMask exists, in_field, in_range;
};

HWY_INLINE FloatMask within_limits(const PointStage& stage, Floats z) {
  const FloatTag d;
  return hn::And(hn::Ge(z, hn::Set(d, stage.nearest)), hn::Le(z, hn::Set(d, stage.farthest)));
}

/// The points of StripeGeometry.
template <int lens_degree>
HWY_INLINE RayPoints points_on_rays(const PointStage& stage, const PointRow& row, std::size_t i,
                                    Floats y) {
  const FloatTag d;
  const Floats E_x = hn::LoadU(d, row.E_x + i), E_y = hn::LoadU(d, row.E_y + i);

  // 1. The ray, and the position q along the stripe where its epipolar line crosses y.
  const Floats p = hn::MulAdd(y, hn::Set(d, stage.unit_scale), hn::Set(d, stage.unit_offset));
  const Floats g = linear(stage.facing, E_x, E_y);
  const Floats place =
      hn::MulAdd(p, linear(stage.place_slope, E_x, E_y), linear(stage.place_constant, E_x, E_y));
  const Floats q = quotient(place, g);

  Floats w = y;
  FloatMask in_field =
      hn::And(hn::Gt(q, hn::Set(d, stage.inner_low)), hn::Lt(q, hn::Set(d, stage.inner_high)));

  // 2. The undistorted coordinate w: by Newton's method, or y plus a polynomial of p and q.
  if constexpr (lens_degree < 0) {
    const Floats rise =
        hn::Mul(hn::Set(d, stage.unit_scale), quotient(linear(stage.place_slope, E_x, E_y), g));
    w = hn::Add(y, plane_polynomial<SolvedLens::start_degree>(stage.lens.data(), p, q));
    w = solved(*stage.solved, y, w, hn::NegMulAdd(rise, y, q), rise, in_field);
    in_field = hn::And(in_field, hn::Le(hn::Abs(q), hn::Set(d, 1)));
  } else if constexpr (lens_degree > 0) {
    w = hn::Add(y, plane_polynomial<lens_degree>(stage.lens.data(), p, q));
  }

  // 3. Depth where the plane of w meets the ray.
  const Floats numerator =
      hn::MulSub(w, hn::Set(d, stage.depth_offset), hn::Set(d, stage.coordinate_offset));
  const Floats denominator =
      hn::NegMulAdd(w, linear(stage.depth, E_x, E_y), linear(stage.coordinate, E_x, E_y));
  const Floats z = quotient(numerator, denominator);

  // 4. The point must exist, in front of both devices, and lie in the field. Most vectors are
  // inside the field at every p, so the exact edges are computed only for the others.
  const Floats largest = hn::Set(d, std::numeric_limits<float>::max());
  const FloatMask before_camera = hn::And(hn::Gt(z, hn::Zero(d)), hn::Le(z, largest));
  const FloatMask before_projector = hn::Gt(hn::Mul(denominator, g), hn::Zero(d));
  if (lens_degree >= 0 && HWY_UNLIKELY(!hn::AllTrue(d, in_field))) {
    in_field = hn::And(hn::Ge(q, edge_polynomial(stage.low_edge, p)),
                       hn::Le(q, edge_polynomial(stage.high_edge, p)));
  }
  if (stage.may_leave_field != 0) {
    in_field = hn::And(in_field, hn::And(hn::Ge(y, hn::Set(d, stage.least_coordinate)),
                                         hn::Le(y, hn::Set(d, stage.largest_coordinate))));
  }

  return {E_x, E_y, z, hn::And(before_camera, before_projector), in_field, within_limits(stage, z)};
}

HWY_INLINE FloatMask is_unflagged(Ints flags) {
  return hn::Not(flagged(flags, PixelFlag::dark | PixelFlag::saturated));
}

HWY_INLINE void store_validity(Ints reasons, Validity* validity) {
  const hn::Rebind<std::uint8_t, IntTag> bytes;
  hn::StoreU(hn::DemoteTo(bytes, reasons), bytes, reinterpret_cast<std::uint8_t*>(validity));
}

/// `past_cache` replaces the row's own, which would be read for each vector.
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
  const IntTag di;
  Ints reason = hn::Zero(di);
  const auto unless = [&](FloatMask good, Validity why) SLIPSTREAM_STEP {
    const Ints other = hn::Set(di, static_cast<std::int32_t>(why));
    reason = hn::IfThenElse(hn::RebindMask(di, good), reason, other);
  };
  unless(points.in_range, Validity::out_of_range);
  unless(points.in_field, Validity::outside_field);
  unless(points.exists, Validity::no_point);
  unless(confirmed, Validity::doubtful_order);
  unless(hn::Not(flagged(flags, PixelFlag::saturated)), Validity::saturated);
  unless(hn::Not(is_dark(flags)), Validity::too_dark);
  return reason;
}

HWY_INLINE void store_dark(const PointRow& row, std::size_t i) {
  store_points(row, row.past_cache, i, nans(), nans(), nans());
  store_validity(hn::Set(IntTag(), static_cast<std::int32_t>(Validity::too_dark)),
                 row.validity + i);
}

/// Stores a vector in which some pixels may have no point.
HWY_INLINE void store_vector(const PointRow& row, std::size_t i, const RayPoints& points,
                             FloatMask confirmed, Ints flags) {
  const FloatTag d;

  const FloatMask good = hn::And(hn::And(is_unflagged(flags), confirmed),
                                 hn::And(points.exists, hn::And(points.in_field, points.in_range)));
  const Floats z = hn::IfThenElse(good, points.z, nans());
  store_points(row, row.past_cache, i, points.E_x, points.E_y, z);

  if (hn::AllTrue(d, good)) return store_validity(hn::Zero(IntTag()), row.validity + i);
  store_validity(reasons(points, confirmed, flags), row.validity + i);
}

/// Computes one vector without its block.
template <int lens_degree>
HWY_NOINLINE void vector_on_rays(const PointStage& stage, const PointRow& row, std::size_t i,
                                 Floats y, FloatMask confirmed, Ints flags) {
  store_vector(row, i, points_on_rays<lens_degree>(stage, row, i, y), confirmed, flags);
}

using VectorOnRays = void (*)(const PointStage&, const PointRow&, std::size_t, Floats, FloatMask,
                              Ints);

/// The function for this degree of PointStage::lens: 0, 3, 5, 7 or 9.
HWY_INLINE VectorOnRays vector_on_rays_for(int lens_degree) {
  constexpr std::array of_degrees{vector_on_rays<0>, vector_on_rays<3>, vector_on_rays<5>,
                                  vector_on_rays<7>, vector_on_rays<9>};

  return lens_degree < 0 ? vector_on_rays<-1> : of_degrees[lens_degree / 2];
}

/// Finds the lanes with enough agreeing neighbours, see FringeOrderConsensus.
class Neighbourhood {
 public:
  HWY_INLINE Neighbourhood(const PointStage& point, const ConsensusStage& stage,
                           const PointRow& row)
      : unit_scale_(hn::Set(FloatTag(), point.unit_scale)),
        unit_offset_(hn::Set(FloatTag(), point.unit_offset)),
        half_fringe_(stage.half_fringe),
        needed_(stage.fewest_neighbours),
        needed_if_doubtful_(stage.fewest_if_doubtful),
        above_(row.above),
        here_(row.coordinate),
        below_(row.below) {}

  HWY_INLINE Floats coordinate(std::size_t i) const { return hn::LoadU(FloatTag(), here_ + i); }

  HWY_INLINE Floats unit_coordinate(std::size_t i) const {
    return hn::MulAdd(coordinate(i), unit_scale_, unit_offset_);
  }

  HWY_INLINE FloatMask confirms(std::size_t i, Ints flags) const {
    Several<1, FloatMask> confirmed;
    confirm<1>(
        i, [flags](std::size_t) SLIPSTREAM_STEP { return flags; }, confirmed);
    return confirmed[0];
  }

  /// Clears the lanes whose coordinate is not trusted; `lanes`: vectors from pixel i on.
  template <std::size_t count>
  HWY_INLINE void keep_trusted(const PointRow& row, std::size_t i,
                               Several<count, FloatMask>& lanes) const {
    const FloatTag d;
    const IntTag di;

    const auto flags = [&](std::size_t k) SLIPSTREAM_STEP {
      return hn::LoadU(di, row.flags + i + k * hn::Lanes(d));
    };
    Ints any = hn::Zero(di);
    each<count>([&](std::size_t k) SLIPSTREAM_STEP { any = hn::Or(any, flags(k)); });

    Several<count, FloatMask> confirmed;

    // By default one neighbour in the row is enough for a pixel without these flags.
    const Ints troubled = hn::Set(di, PixelFlag::saturated | PixelFlag::doubtful_order);
    if (needed_ == 1 && hn::AllTrue(di, hn::Eq(hn::And(any, troubled), hn::Zero(di)))) {
      FloatMask all = hn::FirstN(d, hn::Lanes(d));
      each<count>([&](std::size_t k) SLIPSTREAM_STEP {
        const std::size_t at = i + k * hn::Lanes(d);
        const Floats y = coordinate(at);
        const FloatMask dark = is_dark(flags(k));
        confirmed[k] = hn::Or(agrees(here_, at - 1, y), agrees(here_, at + 1, y));
        all = hn::And(all, hn::Or(confirmed[k], dark));
        confirmed[k] = hn::AndNot(dark, confirmed[k]);
      });

      if (HWY_LIKELY(hn::AllTrue(d, all))) {
        return each<count>([&](std::size_t k)
                               SLIPSTREAM_STEP { lanes[k] = hn::And(lanes[k], confirmed[k]); });
      }
    }

    // Some lanes are flagged, or need the rows above and below.
    confirm<count>(i, flags, confirmed);
    each<count>([&](std::size_t k) SLIPSTREAM_STEP {
      lanes[k] = hn::And(hn::And(lanes[k], is_unflagged(flags(k))), confirmed[k]);
    });
  }

 private:
  /// Finds the lanes, from pixel i on, with enough agreeing neighbours; undefined for dark pixels.
  template <std::size_t count, class Flags>
  HWY_INLINE void confirm(std::size_t i, const Flags& flags,
                          Several<count, FloatMask>& confirmed) const {
    const FloatTag d;
    const IntTag di;

    Several<count> y;
    Several<count, Ints> missing;

    // Each agreeing neighbour takes one off the number still missing.
    const auto count_agreeing = [&](const float* others, std::size_t from) SLIPSTREAM_STEP {
      each<count>([&](std::size_t k) SLIPSTREAM_STEP {
        const FloatMask agreeing = agrees(others, from + k * hn::Lanes(d), y[k]);
        // Masks are -1 as integers.
        missing[k] = hn::Add(missing[k], hn::VecFromMask(di, hn::RebindMask(di, agreeing)));
      });
    };

    // Whether every lane that is not dark has enough.
    const auto settled = [&]() SLIPSTREAM_STEP {
      FloatMask all = hn::FirstN(d, hn::Lanes(d));
      each<count>([&](std::size_t k) SLIPSTREAM_STEP {
        confirmed[k] = hn::RebindMask(d, hn::Lt(missing[k], hn::Set(di, 1)));
        all = hn::And(all, hn::Or(is_dark(flags(k)), confirmed[k]));
      });
      return hn::AllTrue(d, all);
    };

    // Doubtful pixels need more neighbours.
    each<count>([&](std::size_t k) SLIPSTREAM_STEP {
      const auto doubtful = hn::TestBit(flags(k), hn::Set(di, PixelFlag::doubtful_order));
      missing[k] = hn::IfThenElse(doubtful, hn::Set(di, needed_if_doubtful_), hn::Set(di, needed_));
      y[k] = coordinate(i + k * hn::Lanes(d));
    });

    // On a surface, the neighbours in the row are enough, or the four nearest.
    count_agreeing(here_, i - 1);
    count_agreeing(here_, i + 1);
    if (settled()) return;

    count_agreeing(above_, i);
    count_agreeing(below_, i);
    if (settled()) return;

    // Last, the four diagonal neighbours.
    for (const float* other : {above_, below_}) {
      count_agreeing(other, i - 1);
      count_agreeing(other, i + 1);
    }
    settled();
  }

  HWY_INLINE FloatMask agrees(const float* others, std::size_t i, Floats y) const {
    const FloatTag d;
    return hn::Lt(hn::Abs(hn::Sub(hn::LoadU(d, others + i), y)), hn::Set(d, half_fringe_));
  }

  Floats unit_scale_, unit_offset_;
  float half_fringe_;
  int needed_, needed_if_doubtful_;
  const float* above_;
  const float* here_;
  const float* below_;
};

/// A single frequency: neighbours confirm nothing, and coordinates are computed from turns.
class Alone {
 public:
  HWY_INLINE Alone(const PointStage& point, const CoordinateStage& stage, const PointRow& row)
      : in_field_(stage),
        scale_(hn::Set(FloatTag(), stage.scale * point.unit_scale)),
        offset_(hn::Set(FloatTag(), point.unit_offset)),
        turn_(row.coordinate) {}

  HWY_INLINE Floats coordinate(std::size_t i) const {
    return in_field_(hn::LoadU(FloatTag(), turn_ + i));
  }

  /// Mapped to [-1, 1] for a turn before the cut; past it wrong, but outside every block's range.
  HWY_INLINE Floats unit_coordinate(std::size_t i) const {
    return hn::MulAdd(hn::LoadU(FloatTag(), turn_ + i), scale_, offset_);
  }

  HWY_INLINE FloatMask confirms(std::size_t, Ints) const {
    return hn::FirstN(FloatTag(), hn::Lanes(FloatTag()));
  }

  /// Turns of dark and saturated pixels are NaN, which is outside the range of every block.
  template <std::size_t count>
  HWY_INLINE void keep_trusted(const PointRow&, std::size_t, Several<count, FloatMask>&) const {}

 private:
  FieldPlacer in_field_;
  Floats scale_, offset_;
  const float* turn_;
};

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
