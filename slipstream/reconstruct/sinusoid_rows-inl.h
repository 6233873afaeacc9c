// Frames to phase and coordinate. Included once for each vector target, see fused_rows.cpp.
#if defined(SLIPSTREAM_RECONSTRUCT_SINUSOID_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SLIPSTREAM_RECONSTRUCT_SINUSOID_ROWS_INL_H_
#undef SLIPSTREAM_RECONSTRUCT_SINUSOID_ROWS_INL_H_
#else
#define SLIPSTREAM_RECONSTRUCT_SINUSOID_ROWS_INL_H_
#endif

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "slipstream/reconstruct/fused_rows.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::ScalableTag<float>;
using IntTag = hn::RebindToSigned<FloatTag>;
using Floats = hn::Vec<FloatTag>;
using Ints = hn::Vec<IntTag>;

/// Calls `body(i)` for the vectors of a row; the last overlaps the one before it where the width is
/// no multiple.
template <class Body>
HWY_INLINE void for_each_vector(int width, const Body& body) {
  const auto count = static_cast<std::size_t>(width);
  const std::size_t lanes = hn::Lanes(FloatTag());
  // One place that calls, so that the body is inlined and its constants stay in registers.
  for (std::size_t next = 0; next < count; next += lanes) body(std::min(next, count - lanes));
}

/// Vectors that are worked on together: each operation of one waits for the one before it, and the
/// others fill the wait.
#if HWY_MAX_BYTES == 64
inline constexpr std::size_t at_once = 4;
#else
inline constexpr std::size_t at_once = 2;
#endif

template <std::size_t count>
using Several = std::array<Floats, count>;

/// One step of the work on each of them, written out so that all stay in registers.
template <std::size_t count, class Step>
HWY_INLINE void each(const Step& step) {
  HWY_UNROLL(16) for (std::size_t k = 0; k < count; ++k) step(k);
}

/// Past the cache a picture that does not fit in it is not read before it is written. `to` is then
/// aligned to eight floats.
HWY_INLINE void store(Floats values, float* to, bool past_cache) {
  const FloatTag d;
  if (!past_cache) return hn::StoreU(values, d, to);
#if HWY_MAX_BYTES == 64
  if (reinterpret_cast<std::uintptr_t>(to) % 64 != 0) {
    const hn::Half<FloatTag> half;
    hn::Stream(hn::LowerHalf(half, values), half, to);
    return hn::Stream(hn::UpperHalf(half, values), half, to + hn::Lanes(half));
  }
#endif
  hn::Stream(values, d, to);
}

/// a / b to one unit in the last place or two, by the approximate reciprocal and one correction:
/// a third of a division's time.
HWY_INLINE Floats quotient(Floats a, Floats b) {
#if HWY_ARCH_X86
  const Floats r = hn::ApproximateReciprocal(b);
  const Floats q = hn::Mul(a, r);
  return hn::MulAdd(r, hn::NegMulAdd(b, q, a), q);
#else
  return hn::Div(a, b);
#endif
}

/// 1 / b as `quotient` has it.
HWY_INLINE Floats reciprocal(Floats b) {
  const Floats one = hn::Set(FloatTag(), 1.0F);
#if HWY_ARCH_X86
  const Floats r = hn::ApproximateReciprocal(b);
  return hn::MulAdd(r, hn::NegMulAdd(b, r, one), r);
#else
  return hn::Div(one, b);
#endif
}

/// atan2(S, C) / (2 pi) in [0, 1], where 1 stands for 0; 0 where both are 0. To 4e-7 rad.
HWY_INLINE Floats angle_in_turns(Floats S, Floats C) {
  const FloatTag d;
  // The angle of the smaller to the greater is an eighth of the circle at most; it is taken from
  // its middle, pi/8, where |q| <= tan(pi/8), so that four terms of the odd polynomial suffice
  // (minimax, 1.1e-7 rad).
  const Floats tangent = hn::Set(d, 0.41421356237F);
  const Floats sine = hn::Abs(S), cosine = hn::Abs(C);
  const Floats smaller = hn::Min(sine, cosine);
  const Floats greater = hn::Max(hn::Max(sine, cosine), hn::Set(d, 1e-30F));
  const Floats q =
      quotient(hn::NegMulAdd(tangent, greater, smaller), hn::MulAdd(tangent, smaller, greater));
  const Floats q2 = hn::Mul(q, q);
  Floats slope = hn::Set(d, -0.01715644503710709F);
  slope = hn::MulAdd(slope, q2, hn::Set(d, 0.03116408851608355F));
  slope = hn::MulAdd(slope, q2, hn::Set(d, -0.05302114738541977F));
  slope = hn::MulAdd(slope, q2, hn::Set(d, 0.15915456249778778F));
  const Floats zero = hn::Zero(d);
  const Floats eighth = hn::Max(hn::MulAdd(slope, q, hn::Set(d, 0.0625F)), zero);
  const Floats quarter =
      hn::IfThenElse(hn::Gt(sine, cosine), hn::Sub(hn::Set(d, 0.25F), eighth), eighth);
  const Floats half = hn::IfThenElse(hn::Lt(C, zero), hn::Sub(hn::Set(d, 0.5F), quarter), quarter);
  return hn::IfThenElse(hn::Lt(S, zero), hn::Sub(hn::Set(d, 1.0F), half), half);
}

template <class Pixel>
HWY_INLINE Ints load_pixels(const Pixel* pixels) {
  return hn::PromoteTo(IntTag(), hn::LoadU(hn::Rebind<Pixel, IntTag>(), pixels));
}

/// What one vector of pixels says: the sum of the frames, the greatest of them, and U and V.
struct FrameSums {
  Ints sum, greatest;
  Floats U, V;
};

/// Eqs. (2.5), (2.6), (2.8), (2.9), (2.11), (2.12), exact in integers and in float, for any pixel
/// of 16 bits.
template <int N, class Pixel>
HWY_INLINE FrameSums closed_form_sums(const Pixel* const* frames, std::size_t i) {
  const auto I = [&](std::size_t n) HWY_ATTR { return load_pixels(frames[n] + i); };
  const auto twice = [](Ints v) HWY_ATTR { return hn::ShiftLeft<1>(v); };
  const Ints I0 = I(0), I1 = I(1), I2 = I(2);
  const IntTag di;
  const FloatTag d;
  if constexpr (N == 3) {
    const Ints others = hn::Add(I1, I2);
    return {hn::Add(I0, others), hn::Max(I0, hn::Max(I1, I2)),
            hn::ConvertTo(d, hn::Sub(twice(I0), others)), hn::ConvertTo(d, hn::Sub(I1, I2))};
  } else if constexpr (N == 4) {
    const Ints I3 = I(3);
    return {hn::Add(hn::Add(I0, I1), hn::Add(I2, I3)), hn::Max(hn::Max(I0, I1), hn::Max(I2, I3)),
            hn::ConvertTo(d, hn::Sub(I0, I2)), hn::ConvertTo(d, hn::Sub(I1, I3))};
  } else {
    static_assert(N == 6);
    (void)di;
    const Ints I3 = I(3), I4 = I(4), I5 = I(5);
    const Ints ends = hn::Add(I1, I5), middle = hn::Add(I2, I4);
    return {hn::Add(hn::Add(I0, I3), hn::Add(ends, middle)),
            hn::Max(hn::Max(hn::Max(I0, I1), hn::Max(I2, I3)), hn::Max(I4, I5)),
            hn::ConvertTo(d, hn::Add(twice(hn::Sub(I0, I3)), hn::Sub(ends, middle))),
            hn::ConvertTo(d, hn::Sub(hn::Add(I1, I2), hn::Add(I4, I5)))};
  }
}

/// The sums of Eqs. (1.5), (1.6) in double: in float their rounding would be more than the phase
/// allows where the modulation is small. A vector of doubles has half the lanes of one of floats.
class DoubleSums {
 public:
  HWY_INLINE DoubleSums() : low_(hn::Zero(Tag())), high_(hn::Zero(Tag())) {}

  HWY_INLINE void add(Ints I, double weight) {
    const Tag dd;
    const Doubles w = hn::Set(dd, weight);
#if HWY_TARGET != HWY_SCALAR
    const hn::Half<IntTag> half;
    high_ = hn::MulAdd(w, hn::PromoteTo(dd, hn::UpperHalf(half, I)), high_);
    low_ = hn::MulAdd(w, hn::PromoteTo(dd, hn::LowerHalf(half, I)), low_);
#else
    low_ = hn::MulAdd(w, hn::PromoteTo(dd, I), low_);
#endif
  }

  /// 0 where the sums of Eq. (1.7) count as 0, see wrapped_angle.
  HWY_INLINE Floats sum() const {
#if HWY_TARGET != HWY_SCALAR
    const hn::Half<FloatTag> half;
    return hn::Combine(FloatTag(), hn::DemoteTo(half, cleared(high_)),
                       hn::DemoteTo(half, cleared(low_)));
#else
    return hn::DemoteTo(FloatTag(), cleared(low_));
#endif
  }

 private:
#if HWY_TARGET != HWY_SCALAR
  using Tag = hn::Repartition<double, FloatTag>;
#else
  using Tag = hn::Rebind<double, FloatTag>;
#endif
  using Doubles = hn::Vec<Tag>;

  static HWY_INLINE Doubles cleared(Doubles sum) {
    return hn::IfThenZeroElse(hn::Lt(hn::Abs(sum), hn::Set(Tag(), 1e-12)), sum);
  }

  Doubles low_, high_;
};

template <class Pixel>
HWY_INLINE FrameSums general_sums(const SinusoidStage& stage, const Pixel* const* frames,
                                  std::size_t i) {
  DoubleSums C, S;
  Ints sum = hn::Zero(IntTag()), greatest = hn::Zero(IntTag());
  for (std::size_t n = 0; n < stage.cosines.size(); ++n) {
    const Ints I = load_pixels(frames[n] + i);
    sum = hn::Add(sum, I);
    greatest = hn::Max(greatest, I);
    C.add(I, stage.cosines[n]);
    S.add(I, stage.sines[n]);
  }
  return {sum, greatest, C.sum(), S.sum()};
}

/// How the phase is corrected, see SinusoidStage. A wave costs a few multiplications; looking two
/// entries up for each lane costs as much as all else that is done to a frame set's row.
enum class Correction { none, wave, table };

/// corrected_phase, in turns; past either end of [0, 1] by what was added.
HWY_INLINE Floats corrected_by_wave(const SinusoidStage& stage, Floats turn) {
  const FloatTag d;
  const Floats N = hn::Set(d, static_cast<float>(stage.steps));
  // Adding 1.5 * 2^23 rounds to the nearest whole number.
  const Floats rounding = hn::Set(d, 12582912.0F);
  const Floats whole = hn::Sub(hn::MulAdd(turn, N, rounding), rounding);
  const Floats r = hn::MulSub(turn, N, whole);
  const Floats r2 = hn::Mul(r, r);
  const float* c = stage.correction_wave.data();
  Floats slope = hn::Set(d, c[0]);
  for (std::size_t i = 1; i < SinusoidStage::wave_terms; ++i) {
    slope = hn::MulAdd(slope, r2, hn::Set(d, c[i]));
  }
  return hn::MulAdd(slope, r, turn);
}

HWY_INLINE Floats corrected_by_table(const SinusoidStage& stage, Floats turn) {
  const FloatTag d;
  const IntTag di;
  const Floats place = hn::Mul(turn, hn::Set(d, stage.segments));
  const Ints segment = hn::ConvertTo(di, place);
  const Floats part = hn::Sub(place, hn::ConvertTo(d, segment));
  const Floats added = hn::GatherIndex(d, stage.correction.data(), segment);
  const Floats rise = hn::GatherIndex(d, stage.correction_rise.data(), segment);
  return hn::Add(turn, hn::MulAdd(part, rise, added));
}

/// Wrapped phase in turns.
template <Correction correction>
HWY_INLINE Floats corrected_turn(const SinusoidStage& stage, const FrameSums& sums) {
  const Floats V = hn::Mul(hn::Set(FloatTag(), stage.sine_weight), sums.V);
  const Floats turn = angle_in_turns(V, sums.U);
  if constexpr (correction == Correction::wave) return corrected_by_wave(stage, turn);
  if constexpr (correction == Correction::table) return corrected_by_table(stage, turn);
  return turn;
}

/// U^2 + sine_square V^2: V^2 of integers is exact, the square of its rounded multiple is not.
HWY_INLINE Floats modulation_square(const SinusoidStage& stage, const FrameSums& sums) {
  const Floats weight = hn::Set(FloatTag(), stage.sine_square);
  return hn::MulAdd(hn::Mul(weight, sums.V), sums.V, hn::Mul(sums.U, sums.U));
}

/// `dark` and `saturated`.
HWY_INLINE Ints exposure_flags(const SinusoidLimits& limits, const FrameSums& sums, Floats square) {
  const FloatTag d;
  const IntTag di;
  const auto is_dark = hn::Lt(square, hn::Set(d, limits.least_square));
  const auto is_saturated = hn::Gt(sums.greatest, hn::Set(di, limits.full_scale - 1));
  return hn::Or(hn::IfThenElseZero(hn::RebindMask(di, is_dark), hn::Set(di, PixelFlag::dark)),
                hn::IfThenElseZero(is_saturated, hn::Set(di, PixelFlag::saturated)));
}

/// What one row of a sinusoid is to give: each kind is compiled on its own.
template <bool another, bool with_modulation, Correction correction>
HWY_INLINE void store_sinusoid(const SinusoidStage& stage, const SinusoidLimits& limits,
                               const FrameSums& sums, const SinusoidRow& row, std::size_t i) {
  const FloatTag d;
  const IntTag di;
  hn::StoreU(corrected_turn<correction>(stage, sums), d, row.turn + i);
  const Floats square = modulation_square(stage, sums);
  Ints flags = exposure_flags(limits, sums, square);
  if constexpr (another) flags = hn::Or(flags, hn::LoadU(di, row.flags + i));
  hn::StoreU(flags, di, row.flags + i);

  if constexpr (!another) {
    store(hn::Mul(hn::ConvertTo(d, sums.sum), hn::Set(d, limits.mean_scale)), row.mean + i,
          row.past_cache);
  }
  if constexpr (with_modulation) {
    Floats modulation = hn::Mul(hn::Sqrt(square), hn::Set(d, stage.modulation_scale));
    if constexpr (another) modulation = hn::Min(modulation, hn::LoadU(d, row.modulation + i));
    hn::StoreU(modulation, d, row.modulation + i);
  }
}

/// Calls `decode` compiled for how this stage is corrected.
template <class Decode>
HWY_INLINE void with_correction(const SinusoidStage& stage, const Decode& decode) {
  if (!stage.correction_wave.empty()) return decode.template operator()<Correction::wave>();
  if (!stage.correction.empty()) return decode.template operator()<Correction::table>();
  decode.template operator()<Correction::none>();
}

template <bool another, bool with_modulation, class Sums>
HWY_INLINE void decode_vectors(const SinusoidStage& stage, const SinusoidLimits& limits,
                               const SinusoidRow& row, const Sums& sums) {
  const auto decode = [&]<Correction correction>() HWY_ATTR {
    for_each_vector(row.width, [&](std::size_t i) HWY_ATTR {
      store_sinusoid<another, with_modulation, correction>(stage, limits, sums(i), row, i);
    });
  };
  with_correction(stage, decode);
}

template <class Sums>
HWY_INLINE void decode_with(const SinusoidStage& stage, const SinusoidLimits& limits,
                            const SinusoidRow& row, const Sums& sums) {
  const bool with_modulation = row.modulation != nullptr;
  if (row.another) {
    if (with_modulation) return decode_vectors<true, true>(stage, limits, row, sums);
    return decode_vectors<true, false>(stage, limits, row, sums);
  }
  if (with_modulation) return decode_vectors<false, true>(stage, limits, row, sums);
  return decode_vectors<false, false>(stage, limits, row, sums);
}

template <class Pixel>
HWY_INLINE void decode_pixels(const SinusoidStage& stage, const SinusoidLimits& limits,
                              const Pixel* const* frames, const SinusoidRow& row) {
  const auto closed_form = [&]<int N>(std::integral_constant<int, N>) HWY_ATTR {
    std::array<const Pixel*, N> rows;
    std::copy_n(frames, N, rows.begin());
    decode_with(stage, limits, row,
                [rows](std::size_t i) HWY_ATTR { return closed_form_sums<N>(rows.data(), i); });
  };
  switch (stage.steps) {
    case 3:
      return closed_form(std::integral_constant<int, 3>());
    case 4:
      return closed_form(std::integral_constant<int, 4>());
    case 6:
      return closed_form(std::integral_constant<int, 6>());
    default:
      return decode_with(stage, limits, row,
                         [&](std::size_t i) HWY_ATTR { return general_sums(stage, frames, i); });
  }
}

void DecodeRow8(const SinusoidStage& stage, const SinusoidLimits& limits,
                const std::uint8_t* const* frames, const SinusoidRow& row) {
  decode_pixels(stage, limits, frames, row);
}

void DecodeRow16(const SinusoidStage& stage, const SinusoidLimits& limits,
                 const std::uint16_t* const* frames, const SinusoidRow& row) {
  decode_pixels(stage, limits, frames, row);
}

/// Turns of one frequency to coordinates in the field, see coordinate_in_field.
class FieldPlacer {
 public:
  explicit HWY_INLINE FieldPlacer(const CoordinateStage& stage)
      : scale_(hn::Set(FloatTag(), stage.scale)),
        period_(hn::Set(FloatTag(), stage.period)),
        periods_(hn::Set(FloatTag(), stage.scale / stage.period)),
        shift_(hn::Set(FloatTag(), -stage.cut / stage.period)) {}

  HWY_INLINE Floats operator()(Floats turns) const {
    const Floats periods = hn::Floor(hn::MulAdd(turns, periods_, shift_));
    return hn::NegMulAdd(period_, periods, hn::Mul(turns, scale_));
  }

 private:
  Floats scale_, period_, periods_, shift_;
};

void PlaceRow(const CoordinateStage& stage, int width, const float* turn, float* coordinate) {
  const FloatTag d;
  const FieldPlacer in_field(stage);
  for_each_vector(width, [&](std::size_t i) HWY_ATTR {
    hn::StoreU(in_field(hn::LoadU(d, turn + i)), d, coordinate + i);
  });
}

void UnwrapRow(const UnwrapStage& stage, int width, const float* high_turn, const float* low_turn,
               std::int32_t hidden, const UnwrappedRow& row) {
  const FloatTag d;
  const IntTag di;
  const FieldPlacer in_field(stage.coordinate);
  const Floats ratio = hn::Set(d, stage.ratio);
  const Floats largest_doubt = hn::Set(d, stage.largest_doubt);
  const Floats nan = hn::Set(d, std::numeric_limits<float>::quiet_NaN());
  for_each_vector(width, [&](std::size_t i) HWY_ATTR {
    const Floats high = hn::LoadU(d, high_turn + i);
    const Floats periods = hn::MulSub(hn::LoadU(d, low_turn + i), ratio, high);
    const Floats k = hn::Round(periods);  // (1.17)
    const Floats y = in_field(hn::Add(high, k));
    const Floats apart = hn::Abs(hn::Sub(periods, k));
    if (row.doubt != nullptr) hn::StoreU(apart, d, row.doubt + i);
    const auto doubtful = hn::Gt(apart, largest_doubt);
    const Ints known = hn::LoadU(di, row.flags + i);
    const Ints doubt =
        hn::IfThenElseZero(hn::RebindMask(di, doubtful), hn::Set(di, PixelFlag::doubtful_order));
    hn::StoreU(hn::Or(known, doubt), di, row.flags + i);
    const auto is_hidden =
        hn::RebindMask(d, hn::Ne(hn::And(known, hn::Set(di, hidden)), hn::Zero(di)));
    hn::StoreU(hn::IfThenElse(is_hidden, nan, y), d, row.coordinate + i);
  });
}

void PhaseRow(int width, const float* turn, float* phase) {
  const FloatTag d;
  // The float below 2 pi; a whole turn is none.
  const Floats two_pi = hn::Set(d, 6.2831850F);
  for_each_vector(width, [&](std::size_t i) HWY_ATTR {
    const Floats t = hn::LoadU(d, turn + i);
    Floats part = hn::Sub(t, hn::Floor(t));
    part = hn::IfThenElseZero(hn::Lt(part, hn::Set(d, 1.0F)), part);
    hn::StoreU(hn::Min(hn::Mul(part, hn::Set(d, 6.2831853F)), two_pi), d, phase + i);
  });
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
