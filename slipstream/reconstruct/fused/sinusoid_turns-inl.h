// Sums of frames to turns, turns to coordinates. Included once for each vector target.
#if defined(SLIPSTREAM_KERNELS_SINUSOID_TURNS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SLIPSTREAM_KERNELS_SINUSOID_TURNS_INL_H_
#undef SLIPSTREAM_KERNELS_SINUSOID_TURNS_INL_H_
#else
#define SLIPSTREAM_KERNELS_SINUSOID_TURNS_INL_H_
#endif

#include <cstddef>
#include <cstdint>

#include <hwy/highway.h>

#include "slipstream/base/vectors-inl.h"
#include "slipstream/reconstruct/fused/frame_sums-inl.h"
#include "slipstream/reconstruct/fused/sinusoid_rows.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// From the first half quadrant.
HWY_INLINE Floats unfolded(Floats eighth, Floats S, Floats C) {
  const FloatTag d;
  const Floats zero = hn::Zero(d);
  const Floats quarter =
      hn::IfThenElse(hn::Gt(hn::Abs(S), hn::Abs(C)), hn::Sub(hn::Set(d, 0.25F), eighth), eighth);
  const Floats half = hn::IfThenElse(hn::Lt(C, zero), hn::Sub(hn::Set(d, 0.5F), quarter), quarter);
  return hn::IfThenElse(hn::Lt(S, zero), hn::Sub(hn::Set(d, 1.0F), half), half);
}

/// atan2(S, C) / (2 pi) of each in [0, 1], where 1 stands for 0; 0 where both are 0. To 4e-7 rad.
template <std::size_t count>
HWY_INLINE Several<count> angles_in_turns(const Several<count>& S, const Several<count>& C) {
  const FloatTag d;
  // The angle of the smaller to the greater is an eighth of the circle at most; it is taken from
  // its middle, pi/8, where |q| <= tan(pi/8), so that four terms of the odd polynomial suffice
  // (minimax, 1.1e-7 rad).
  const Floats tangent = hn::Set(d, 0.41421356237F);
  Several<count> numerator, denominator;
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    const Floats sine = hn::Abs(S[k]), cosine = hn::Abs(C[k]);
    const Floats smaller = hn::Min(sine, cosine);
    const Floats greater = hn::Max(hn::Max(sine, cosine), hn::Set(d, 1e-30F));
    numerator[k] = hn::NegMulAdd(tangent, greater, smaller);
    denominator[k] = hn::MulAdd(tangent, smaller, greater);
  });
  const Several<count> q = quotients<count>(numerator, denominator);
  Several<count> q2, turn;
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    q2[k] = hn::Mul(q[k], q[k]);
    turn[k] = hn::Set(d, -0.01715644503710709F);
  });
  add_term<count>(turn, q2, 0.03116408851608355F);
  add_term<count>(turn, q2, -0.05302114738541977F);
  add_term<count>(turn, q2, 0.15915456249778778F);
  add_term<count>(turn, q, 0.0625F);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    turn[k] = unfolded(hn::Max(turn[k], hn::Zero(d)), S[k], C[k]);
  });
  return turn;
}

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

/// corrected_phase, where it is not folded: a wave costs a few multiplications; looking two entries
/// up for each lane costs as much as all else that is done to a row of frames.
HWY_INLINE Floats corrected_after(const SinusoidStage& stage, Floats turn) {
  if (stage.correction_wave.empty() && stage.correction.empty()) return turn;
  if (!stage.correction_wave.empty()) turn = corrected_by_wave(stage, turn);
  if (!stage.correction.empty()) turn = corrected_by_table(stage, turn);
  // It may have led past either end.
  return hn::Sub(turn, hn::Floor(turn));
}

/// Wrapped phase in turns, of sums.
template <std::size_t count>
HWY_INLINE Several<count> corrected_turns(const SinusoidStage& stage, Several<count> V,
                                          const Several<count>& U) {
  const Floats weight = hn::Set(FloatTag(), stage.sine_weight);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP { V[k] = hn::Mul(weight, V[k]); });
  Several<count> turn = angles_in_turns<count>(V, U);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP { turn[k] = corrected_after(stage, turn[k]); });
  return turn;
}

/// U^2 + sine_square V^2: V^2 of integers is exact, the square of its rounded multiple is not.
HWY_INLINE Floats modulation_square(const SinusoidStage& stage, const FrameSums& sums) {
  const Floats weight = hn::Set(FloatTag(), stage.sine_square);
  return hn::MulAdd(hn::Mul(weight, sums.V), sums.V, hn::Mul(sums.U, sums.U));
}

HWY_INLINE FloatMask is_dark(Ints flags) {
  const IntTag di;
  return hn::RebindMask(FloatTag(),
                        hn::Ne(hn::And(flags, hn::Set(di, PixelFlag::dark)), hn::Zero(di)));
}

HWY_INLINE Ints saturation_flag(const SinusoidLimits& limits, const FrameSums& sums) {
  const IntTag di;
  return hn::IfThenElseZero(hn::Gt(sums.greatest, hn::Set(di, limits.full_scale - 1)),
                            hn::Set(di, PixelFlag::saturated));
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

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
