// Frames to sums of sinusoids to turns to coordinates. Included once per vector target.
#if defined(SLIPSTREAM_KERNELS_SINUSOID_SUMS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SLIPSTREAM_KERNELS_SINUSOID_SUMS_INL_H_
#undef SLIPSTREAM_KERNELS_SINUSOID_SUMS_INL_H_
#else
#define SLIPSTREAM_KERNELS_SINUSOID_SUMS_INL_H_
#endif

#include <cstdint>
#include <limits>
#include <span>

#include <hwy/highway.h>

#include "base/vectors-inl.h"
#include "reconstruct/fused/sinusoid_rows.h"
#include "reconstruct/fused/unwrap_rows.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {
template <class Pixel>
HWY_INLINE Ints load_pixels(const Pixel* pixels) {
  return hn::PromoteTo(IntTag(), hn::LoadU(hn::Rebind<Pixel, IntTag>(), pixels));
}

/// Sums over a vector of pixels: of all frames, their maximum, and U and V.
struct FrameSums {
  Floats sum;
  Ints greatest;
  Floats U, V;
};

/// Sums of Eqs. (1.5), (1.6) in double: in float, rounding would exceed the allowed phase error at
/// low modulation. A vector of doubles has half the lanes of a vector of floats.
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

  /// Sums that count as 0 in Eq. (1.7) become 0, see wrapped_angle.
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

/// a + b sqrt(5) for whole numbers below 2^19, accurate to one or two units in the last place even
/// if the terms nearly cancel. The sums of Eqs. (1.5), (1.6) have this form for N = 5, up to scale.
HWY_INLINE Floats with_root_of_five(Floats a, Floats b) {
#if HWY_NATIVE_FMA
  const FloatTag d;
  // sqrt(5) as 2.25 plus two parts: the first sum is exact, the next two are rounded once.
  const Floats exact = hn::MulAdd(b, hn::Set(d, 2.25F), a);
  const Floats most = hn::MulAdd(b, hn::Set(d, -0.01393202227F), exact);
  return hn::MulAdd(b, hn::Set(d, -2.341203874e-10F), most);
#else
  const IntTag di;
  DoubleSums sum;
  sum.add(hn::ConvertTo(di, a), 1);
  sum.add(hn::ConvertTo(di, b), 2.23606797749978969);
  return sum.sum();
#endif
}

/// N = 5, in both full phase channels: U is 10 C, and V is 5 S / sin(2 pi / 5). Frames n and N - n
/// have the same cosine and opposite sines.
struct FifthSums {
  FrameSums first;
  Floats U, V;  ///< of the second channel, to a millionth: enough to choose a period
};

/// Whole numbers of this size are exact in float, and adding a multiple takes one instruction.
template <class Pixel>
HWY_INLINE FifthSums fifth_sums(const Pixel* const* frames, std::size_t i) {
  const FloatTag d;
  const auto I = [&](std::size_t n) SLIPSTREAM_STEP { return load_pixels(frames[n] + i); };
  const auto level = [&](Ints v) SLIPSTREAM_STEP { return hn::ConvertTo(d, v); };
  const Floats two = hn::Set(d, 2.0F), four = hn::Set(d, 4.0F), root = hn::Set(d, 2.2360679775F);

  // Sums and differences of the frames that share a cosine.
  const Ints I0 = I(0), I1 = I(1), I2 = I(2), I3 = I(3), I4 = I(4);
  const Ints outer = hn::Add(I1, I4), inner = hn::Add(I2, I3), others = hn::Add(outer, inner);
  const Floats rise = level(hn::Sub(I1, I4)), inner_rise = level(hn::Sub(I2, I3));

  const Floats whole = hn::MulSub(four, level(I0), level(others));
  const Floats apart = level(hn::Sub(outer, inner));

  return {{level(hn::Add(I0, others)), hn::Max(hn::Max(hn::Max(I0, I1), hn::Max(I2, I3)), I4),
           with_root_of_five(whole, apart),
           with_root_of_five(hn::MulSub(two, rise, inner_rise), inner_rise)},
          hn::NegMulAdd(root, apart, whole),
          hn::MulSub(root, rise, hn::MulAdd(two, inner_rise, rise))};
}

/// Eqs. (2.5), (2.6), (2.8), (2.9), (2.11), (2.12), exact for 16-bit pixels; and N = 5.
template <int N, class Pixel>
HWY_INLINE FrameSums closed_form_sums(const Pixel* const* frames, std::size_t i) {
  const auto I = [&](std::size_t n) SLIPSTREAM_STEP { return load_pixels(frames[n] + i); };
  const auto twice = [](Ints v) SLIPSTREAM_STEP { return hn::ShiftLeft<1>(v); };
  const Ints I0 = I(0), I1 = I(1), I2 = I(2);
  const FloatTag d;

  // For each N: the sum of all frames, the greatest, U and V.
  if constexpr (N == 3) {
    const Ints others = hn::Add(I1, I2);
    return {hn::ConvertTo(d, hn::Add(I0, others)), hn::Max(I0, hn::Max(I1, I2)),
            hn::ConvertTo(d, hn::Sub(twice(I0), others)), hn::ConvertTo(d, hn::Sub(I1, I2))};
  } else if constexpr (N == 4) {
    const Ints I3 = I(3);
    return {hn::ConvertTo(d, hn::Add(hn::Add(I0, I1), hn::Add(I2, I3))),
            hn::Max(hn::Max(I0, I1), hn::Max(I2, I3)), hn::ConvertTo(d, hn::Sub(I0, I2)),
            hn::ConvertTo(d, hn::Sub(I1, I3))};
  } else if constexpr (N == 5) {
    return fifth_sums(frames, i).first;
  } else {
    static_assert(N == 6);
    const Ints I3 = I(3), I4 = I(4), I5 = I(5);
    const Ints ends = hn::Add(I1, I5), middle = hn::Add(I2, I4);
    return {hn::ConvertTo(d, hn::Add(hn::Add(I0, I3), hn::Add(ends, middle))),
            hn::Max(hn::Max(hn::Max(I0, I1), hn::Max(I2, I3)), hn::Max(I4, I5)),
            hn::ConvertTo(d, hn::Add(twice(hn::Sub(I0, I3)), hn::Sub(ends, middle))),
            hn::ConvertTo(d, hn::Sub(hn::Add(I1, I2), hn::Add(I4, I5)))};
  }
}

template <class Pixel>
HWY_INLINE FrameSums general_sums(const SinusoidStage& stage, const Pixel* const* frames,
                                  std::size_t i) {
  const FloatTag d;

  DoubleSums C, S;
  Floats sum = hn::Zero(d);
  Ints greatest = hn::Zero(IntTag());

  for (std::size_t n = 0; n < stage.cosines.size(); ++n) {
    const Ints I = load_pixels(frames[n] + i);
    const float mean = stage.means.empty() ? 1 : stage.means[n];
    sum = hn::MulAdd(hn::Set(d, mean), hn::ConvertTo(d, I), sum);
    greatest = hn::Max(greatest, I);

    C.add(I, stage.cosines[n]);
    S.add(I, stage.sines[n]);
  }

  return {sum, greatest, C.sum(), S.sum()};
}

/// The same for whole-number weights, exact in float.
template <class Pixel>
HWY_INLINE FrameSums whole_sums(std::span<const SinusoidStage::WholeWeights> weights,
                                const Pixel* const* frames, std::size_t i) {
  const FloatTag d;

  Floats sum = hn::Zero(d), U = sum, V = sum;
  Ints greatest = hn::Zero(IntTag());

  for (std::size_t n = 0; n < weights.size(); ++n) {
    const Ints I = load_pixels(frames[n] + i);
    const Floats level = hn::ConvertTo(d, I);
    greatest = hn::Max(greatest, I);
    sum = hn::MulAdd(hn::Set(d, weights[n].mean), level, sum);
    U = hn::MulAdd(hn::Set(d, weights[n].cosine), level, U);
    V = hn::MulAdd(hn::Set(d, weights[n].sine), level, V);
  }

  return {sum, greatest, U, V};
}

/// Whether any frame is at full scale, tested for many pixels at once because it is rare.
template <class Pixel>
class Saturation {
 public:
  HWY_INLINE Saturation(const Pixel* const* frames, std::size_t count, std::int32_t full_scale)
      : frames_(frames),
        count_(count),
        full_scale_(static_cast<Pixel>(full_scale)),
        occurs_(full_scale <= std::numeric_limits<Pixel>::max()) {}

  /// Among `vectors` vectors of floats from pixel `i` on.
  template <std::size_t vectors>
  HWY_INLINE bool among(std::size_t i) const {
    if (!occurs_) return false;

    constexpr std::size_t pixels = vectors * hn::MaxLanes(FloatTag());
    const hn::CappedTag<Pixel, pixels> d;
    const auto full_scale = hn::Set(d, full_scale_);

    bool saturated = false;
    for (std::size_t start = 0; start < pixels; start += hn::Lanes(d)) {
      auto greatest = hn::Zero(d);
      for (std::size_t n = 0; n < count_; ++n) {
        greatest = hn::Max(greatest, hn::LoadU(d, frames_[n] + i + start));
      }

      // A pixel is saturated if its greatest level is not below full scale.
      saturated |= !hn::AllFalse(d, hn::Eq(hn::Max(greatest, full_scale), greatest));
    }

    return saturated;
  }

 private:
  const Pixel* const* frames_;
  std::size_t count_;
  Pixel full_scale_;
  bool occurs_;
};

/// Extends an angle of the first half quadrant to the full circle.
HWY_INLINE Floats unfolded(Floats eighth, Floats S, Floats C) {
  const FloatTag d;
  const Floats zero = hn::Zero(d);

  // Mirrored at 45, 90 and 180 degrees in turn.
  const Floats quarter =
      hn::IfThenElse(hn::Gt(hn::Abs(S), hn::Abs(C)), hn::Sub(hn::Set(d, 0.25F), eighth), eighth);
  const Floats half = hn::IfThenElse(hn::Lt(C, zero), hn::Sub(hn::Set(d, 0.5F), quarter), quarter);
  return hn::IfThenElse(hn::Lt(S, zero), hn::Sub(hn::Set(d, 1.0F), half), half);
}

/// atan2(S, C) / (2 pi) in [0, 1], where 1 means 0; 0 if both are 0. Accurate to 4e-7 rad.
template <std::size_t count>
HWY_INLINE Several<count> angles_in_turns(const Several<count>& S, const Several<count>& C) {
  const FloatTag d;
  // The angle of the smaller to the larger is at most pi/4. Measured from pi/8, |q| <= tan(pi/8),
  // so four terms of the odd polynomial suffice (minimax, 1.1e-7 rad).
  const Floats tangent = hn::Set(d, 0.41421356237F);

  Several<count> numerator, denominator;
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    const Floats sine = hn::Abs(S[k]), cosine = hn::Abs(C[k]);
    const Floats smaller = hn::Min(sine, cosine);
    const Floats greater = hn::Max(hn::Max(sine, cosine), hn::Set(d, 1e-30F));
    numerator[k] = hn::NegMulAdd(tangent, greater, smaller);
    denominator[k] = hn::MulAdd(tangent, smaller, greater);
  });

  // The polynomial in q^2, highest power first, then times q, plus pi/8 (0.0625 turns).
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

/// cos(pi y) from 2 y - 1 in [-1, 1], as an odd polynomial (minimax, 3.4e-9).
HWY_INLINE Floats cosine_of_half_turns(Floats u) {
  const FloatTag d;
  const Floats square = hn::Mul(u, u);
  Floats sum = hn::Set(d, -0.00015082055608628409F);

  for (const float next :
       {0.004672227907111415F, -0.07968848053050398F, 0.6459633598638469F, -1.5707962900222812F}) {
    sum = hn::MulAdd(sum, square, hn::Set(d, next));
  }

  return hn::Mul(sum, u);
}

/// CueReference at y, held at the ends of the field: linear, or a cosine.
template <bool cosine>
HWY_INLINE Floats cue_reference(Floats y) {
  const FloatTag d;
  const Floats one = hn::Set(d, 1.0F);

  const Floats held = hn::Clamp(y, hn::Zero(d), one);
  const Floats linear = hn::MulSub(hn::Set(d, 2.0F), held, one);
  if constexpr (cosine) return cosine_of_half_turns(linear);
  return linear;
}

/// corrected_phase, in turns; exceeds [0, 1] by the correction at most.
HWY_INLINE Floats corrected_by_wave(const SinusoidStage& stage, Floats turn) {
  const FloatTag d;
  const Floats N = hn::Set(d, static_cast<float>(stage.steps));

  // Adding 1.5 * 2^23 rounds to the nearest whole number.
  const Floats rounding = hn::Set(d, 12582912.0F);
  const Floats whole = hn::Sub(hn::MulAdd(turn, N, rounding), rounding);

  // r is the distance of N times the turn from the nearest whole number.
  const Floats r = hn::MulSub(turn, N, whole);
  const Floats r2 = hn::Mul(r, r);

  // The odd polynomial: its slope in r^2, times r.
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

  // Linear between the table's entries.
  const Floats place = hn::Mul(turn, hn::Set(d, stage.segments));
  const Ints segment = hn::ConvertTo(di, place);
  const Floats part = hn::Sub(place, hn::ConvertTo(d, segment));
  const Floats added = hn::GatherIndex(d, stage.correction.data(), segment);
  const Floats rise = hn::GatherIndex(d, stage.correction_rise.data(), segment);

  return hn::Add(turn, hn::MulAdd(part, rise, added));
}

/// corrected_phase, if not folded. A wave costs a few multiplications; looking up two entries per
/// lane costs as much as the rest of the row's decoding.
HWY_INLINE Floats corrected_after(const SinusoidStage& stage, Floats turn) {
  if (stage.correction_wave.empty() && stage.correction.empty()) return turn;
  if (!stage.correction_wave.empty()) turn = corrected_by_wave(stage, turn);
  if (!stage.correction.empty()) turn = corrected_by_table(stage, turn);

  // The correction may exceed either end.
  return hn::Sub(turn, hn::Floor(turn));
}

/// Wrapped phase in turns, from sums.
template <std::size_t count>
HWY_INLINE Several<count> corrected_turns(const SinusoidStage& stage, Several<count> V,
                                          const Several<count>& U) {
  // The phase is the angle of U and sine_weight V.
  const Floats weight = hn::Set(FloatTag(), stage.sine_weight);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP { V[k] = hn::Mul(weight, V[k]); });
  Several<count> turn = angles_in_turns<count>(V, U);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP { turn[k] = corrected_after(stage, turn[k]); });

  return turn;
}

/// From steps that begin elsewhere or go backwards to the turns of the band's phase.
template <std::size_t count>
HWY_INLINE Several<count> without_shifts(const SinusoidStage& stage, Several<count> turn) {
  if (stage.direction == 1 && stage.offset == 0) return turn;

  const FloatTag d;
  const Floats direction = hn::Set(d, stage.direction), offset = hn::Set(d, stage.offset);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    turn[k] = hn::MulAdd(direction, turn[k], offset);
    turn[k] = hn::Sub(turn[k], hn::Floor(turn[k]));
  });

  return turn;
}

/// U^2 + sine_square V^2; V^2 of an integer is exact, the square of its rounded multiple is not.
HWY_INLINE Floats modulation_square(const SinusoidStage& stage, const FrameSums& sums) {
  const Floats weight = hn::Set(FloatTag(), stage.sine_square);
  return hn::MulAdd(hn::Mul(weight, sums.V), sums.V, hn::Mul(sums.U, sums.U));
}

HWY_INLINE Floats nans() {
  return hn::Set(FloatTag(), std::numeric_limits<float>::quiet_NaN());
}

/// Pixels with any of the flags `which`.
HWY_INLINE FloatMask flagged(Ints flags, std::int32_t which) {
  const IntTag di;
  return hn::RebindMask(FloatTag(), hn::Ne(hn::And(flags, hn::Set(di, which)), hn::Zero(di)));
}

HWY_INLINE FloatMask is_dark(Ints flags) {
  return flagged(flags, PixelFlag::dark);
}

HWY_INLINE Ints flag_where(FloatMask where, PixelFlag flag) {
  const IntTag di;
  return hn::IfThenElseZero(hn::RebindMask(di, where), hn::Set(di, flag));
}

HWY_INLINE Ints saturation_flag(const SinusoidLimits& limits, Ints greatest) {
  const auto saturated = hn::Gt(greatest, hn::Set(IntTag(), limits.full_scale - 1));
  return flag_where(hn::RebindMask(FloatTag(), saturated), PixelFlag::saturated);
}

/// Turns of one frequency to coordinates in the field, see coordinate_in_field.
class FieldPlacer {
 public:
  explicit HWY_INLINE FieldPlacer(const CoordinateStage& stage)
      : scale_(hn::Set(FloatTag(), stage.scale)),
        period_(hn::Set(FloatTag(), stage.period)),
        periods_(hn::Set(FloatTag(), stage.fields_of_turn)),
        shift_(hn::Set(FloatTag(), -stage.cut_fields)) {}

  HWY_INLINE Floats operator()(Floats turns) const {
    const Floats periods = hn::Floor(hn::MulAdd(turns, periods_, shift_));
    return hn::NegMulAdd(period_, periods, hn::Mul(turns, scale_));
  }

 private:
  Floats scale_, period_, periods_, shift_;
};

/// A vector of results, with all flags of its pixels.
struct Unwrapped {
  Floats y, doubt;
  Ints flags;
};

/// Stores a row of `unwrapped(i, flags)`; vectors of hidden pixels are left out.
template <class Unwrap>
HWY_INLINE void unwrap_vectors(const UnwrappedRow& row, float largest_doubt,
                               const Unwrap& unwrapped) {
  const FloatTag d;
  const IntTag di;
  const std::int32_t hidden = row.hidden;
  for_each_vector(row.width, [&](std::size_t i) SLIPSTREAM_STEP {
    const Ints known = hn::LoadU(di, row.flags + i);
    if (hn::AllTrue(d, flagged(known, hidden))) return hn::StoreU(nans(), d, row.coordinate + i);

    const Unwrapped pixels = unwrapped(i, known);

    if (row.doubt != nullptr) {
      const Floats before = row.keeps_doubt ? hn::LoadU(d, row.doubt + i) : hn::Zero(d);
      hn::StoreU(hn::Max(pixels.doubt, before), d, row.doubt + i);
    }

    const FloatMask doubtful = hn::Gt(pixels.doubt, hn::Set(d, largest_doubt));
    hn::StoreU(hn::Or(pixels.flags, flag_where(doubtful, PixelFlag::doubtful_order)), di,
               row.flags + i);

    // Pixels with a hidden flag give no coordinate.
    const Floats y = hn::IfThenElse(flagged(pixels.flags, hidden), nans(), pixels.y);
    hn::StoreU(y, d, row.coordinate + i);
  });
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
