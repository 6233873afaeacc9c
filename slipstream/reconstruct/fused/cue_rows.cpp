// Coordinates of a row from frames with a cue.

#include "slipstream/reconstruct/fused/rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slipstream/reconstruct/fused/cue_rows.cpp"
#include <hwy/foreach_target.h>

#include "slipstream/base/vectors-inl.h"
#include "slipstream/reconstruct/fused/sinusoid_sums-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// For N >= 5 the cue is a sinusoid.
template <int steps>
constexpr bool is_circle = steps != 3 && steps != 4;

/// Sums of a vector of pixels: of the measuring band, and of the cue's channel times N, or the
/// cue's cosine and sine up to a factor.
struct CueSums {
  FrameSums high;
  Floats cue, cue_sine;
};

/// N above 6. Sum and difference of frames n and N - n, of opposite sines, serve both channels.
template <class Pixel>
HWY_INLINE CueSums two_channel_sums(const SinusoidStage& stage, const CueStage& cue,
                                    const Pixel* const* frames, std::size_t i) {
  const Ints first = load_pixels(frames[0] + i);
  Ints sum = first, greatest = first;
  DoubleSums C, S, cue_C, cue_S;
  C.add(first, stage.cosines[0]);
  cue_C.add(first, cue.cosines[0]);
  const std::size_t N = stage.cosines.size();
  for (std::size_t n = 1; 2 * n < N; ++n) {
    const Ints I = load_pixels(frames[n] + i), J = load_pixels(frames[N - n] + i);
    const Ints both = hn::Add(I, J), apart = hn::Sub(I, J);
    sum = hn::Add(sum, both);
    greatest = hn::Max(greatest, hn::Max(I, J));
    C.add(both, stage.cosines[n]);
    S.add(apart, stage.sines[n]);
    cue_C.add(both, cue.cosines[n]);
    cue_S.add(apart, cue.sines[n]);
  }
  if (N % 2 == 0) {
    const Ints middle = load_pixels(frames[N / 2] + i);
    sum = hn::Add(sum, middle);
    greatest = hn::Max(greatest, middle);
    C.add(middle, stage.cosines[N / 2]);
    cue_C.add(middle, cue.cosines[N / 2]);
  }
  return {{hn::ConvertTo(FloatTag(), sum), greatest, C.sum(), S.sum()}, cue_C.sum(), cue_S.sum()};
}

/// `steps`: N if its sums are compiled, else 0.
template <int steps, class Pixel>
HWY_INLINE CueSums cue_sums(const SinusoidStage& stage, const CueStage& cue,
                            const Pixel* const* frames, std::size_t i) {
  const FloatTag d;
  const auto I = [&](std::size_t n) SLIPSTREAM_STEP { return load_pixels(frames[n] + i); };
  if constexpr (steps == 3) {
    const FrameSums sums = closed_form_sums<3>(frames, i);
    return {sums, sums.sum, hn::Zero(d)};
  } else if constexpr (steps == 4) {
    const Ints half_phase = hn::Sub(hn::Add(I(0), I(2)), hn::Add(I(1), I(3)));  // (3.70)
    return {closed_form_sums<4>(frames, i), hn::ConvertTo(d, half_phase), hn::Zero(d)};
  } else if constexpr (steps == 5) {
    const FifthSums sums = fifth_sums(frames, i);
    return {sums.first, sums.U, sums.V};
  } else if constexpr (steps == 6) {  // U is 6 C, V is 6 S / sqrt(3)
    const Ints rising = hn::Add(I(1), I(4)), falling = hn::Add(I(2), I(5));
    const Ints U = hn::Sub(hn::ShiftLeft<1>(hn::Add(I(0), I(3))), hn::Add(rising, falling));
    return {closed_form_sums<6>(frames, i), hn::ConvertTo(d, U),
            hn::ConvertTo(d, hn::Sub(rising, falling))};
  } else {
    return two_channel_sums(stage, cue, frames, i);
  }
}

/// Angles in turns, times a factor.
template <std::size_t count>
HWY_INLINE Several<count> angles_times(float factor, const Several<count>& S,
                                       const Several<count>& C) {
  Several<count> angles = angles_in_turns<count>(S, C);
  const Floats f = hn::Set(FloatTag(), factor);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP { angles[k] = hn::Mul(f, angles[k]); });
  return angles;
}

/// CueEvidence::coordinate, in periods of the high frequency, from the cue's channel, its sine for
/// N >= 5, and B_1^c; without light 0 for N = 3 and 4.
template <int steps, std::size_t count>
HWY_INLINE Several<count> cue_periods(const CueStage& cue, const CueLimits& limits,
                                      const Several<count>& channel, Several<count> sine,
                                      const Several<count>& modulation) {
  const FloatTag d;
  Several<count> R, periods;
  if constexpr (is_circle<steps>) {
    const Floats weight = hn::Set(d, cue.sine_weight);
    each<count>([&](std::size_t k) SLIPSTREAM_STEP { sine[k] = hn::Mul(weight, sine[k]); });
    return angles_times(cue.periods, sine, channel);  // (3.88)
  }
  const Floats one = hn::Set(d, 1.0F), least = hn::Set(d, 1e-9F);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    const Floats value =
        hn::MulSub(channel[k], hn::Set(d, 1.0F / steps), hn::Set(d, limits.ambient));
    const Floats ratio = quotient(value, hn::Max(modulation[k], least));
    R[k] = hn::Clamp(hn::MulSub(hn::Set(d, cue.gain), ratio, hn::Set(d, cue.offset)), hn::Neg(one),
                     one);
  });
  if constexpr (steps == 3) {
    const Floats half = hn::Set(d, 0.5F * cue.periods);
    each<count>([&](std::size_t k) SLIPSTREAM_STEP { periods[k] = hn::MulAdd(R[k], half, half); });
  } else {
    each<count>([&](std::size_t k) SLIPSTREAM_STEP {
      sine[k] = hn::Sqrt(hn::Max(hn::NegMulAdd(R[k], R[k], one), hn::Zero(d)));
    });
    periods = angles_times(2 * cue.periods, sine, R);
  }
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    periods[k] = hn::IfThenElseZero(hn::Gt(modulation[k], least), periods[k]);
  });
  return periods;
}

/// Replaces a turn of 1 by 0.
HWY_INLINE Floats within_a_turn(Floats turn) {
  return hn::IfThenElseZero(hn::Lt(turn, hn::Set(FloatTag(), 1.0F)), turn);
}

/// CueEvidence::nearest_order.
template <int steps>
HWY_INLINE Floats nearest_order(const CueStage& cue, Floats periods) {
  const FloatTag d;
  const Floats k = hn::Round(periods);
  if constexpr (is_circle<steps>) return k;
  return hn::Clamp(k, hn::Zero(d), hn::Set(d, cue.periods - 1));
}

/// Decodes one row. Members are copies, so that no store can alias them.
template <int steps, class Pixel>
class CueVectors {
 public:
  HWY_INLINE CueVectors(const SinusoidStage& stage, const CueStage& cue, const Pixel* const* frames,
                        const CueRow& row)
      : stage_(stage),
        cue_(cue),
        row_(row),
        all_frames_(frames),
        saturation_(steps == 0 ? frames : frames_.data(), steps == 0 ? stage.cosines.size() : steps,
                    row.limits.full_scale),
        in_field_(cue.coordinate) {
    std::copy_n(frames, steps, frames_.begin());
  }
  CueVectors(const CueVectors&) = delete;  // it points into itself
  CueVectors& operator=(const CueVectors&) = delete;
  ~CueVectors() = default;

  /// Decodes vectors from pixel `i` on.
  template <std::size_t count>
  HWY_INLINE void decode(std::size_t i) const {
    const FloatTag d;
    const bool decoding = row_.turn != nullptr, wants_modulation = row_.modulation != nullptr;
    Several<count> U, V, square, sum, channel, sine, modulation;
    FloatMask all_hidden = hn::FirstN(d, hn::Lanes(d));
    each<count>([&](std::size_t k) SLIPSTREAM_STEP {
      const CueSums sums = at(i + k * hn::Lanes(d));
      U[k] = sums.high.U;
      V[k] = sums.high.V;
      channel[k] = sums.cue;
      sine[k] = sums.cue_sine;
      sum[k] = sums.high.sum;
      square[k] = modulation_square(stage_, sums.high);
      modulation[k] = square[k];  // not used unless computed below
      if (!is_circle<steps> || wants_modulation) {
        modulation[k] = hn::Mul(hn::Sqrt(square[k]), hn::Set(d, stage_.modulation_scale));
      }
      if (wants_modulation) hn::StoreU(modulation[k], d, row_.modulation + i + k * hn::Lanes(d));
      all_hidden = hn::And(all_hidden, hn::And(cannot_vote(square[k]), is_dark_at(square[k])));
    });
    if (!casts_shade && !decoding && hn::AllTrue(d, all_hidden)) {
      return each<count>([&](std::size_t k) SLIPSTREAM_STEP {
        store_hidden(i + k * hn::Lanes(d), sum[k], square[k]);
      });
    }

    // On the circle, whole turns make no difference.
    Several<count> turn = corrected_turns<count>(stage_, V, U);
    if constexpr (!is_circle<steps>) {
      each<count>([&](std::size_t k) SLIPSTREAM_STEP { turn[k] = within_a_turn(turn[k]); });
    }
    const Several<count> cue_place =
        cue_periods<steps, count>(cue_, row_.cue_limits, channel, sine, modulation);
    const bool saturated = saturation_.template among<count>(i);
    each<count>([&](std::size_t k) SLIPSTREAM_STEP {
      const std::size_t pixel = i + k * hn::Lanes(d);
      const Floats periods = hn::Sub(cue_place[k], turn[k]);
      const Floats order = nearest_order<steps>(cue_, periods);
      const Floats y = coordinate(hn::Add(turn[k], order));
      Floats doubt = hn::Abs(hn::Sub(periods, order));
      if constexpr (!is_circle<steps>) doubt = hn::Min(doubt, hn::Set(d, 0.5F));
      store_flags(pixel, square[k], doubt, saturated);
      fetch_ahead(row_.mean + pixel, row_.past_cache);
      store(shown_mean(sum[k], modulation[k], y), row_.mean + pixel, row_.past_cache);
      if (HWY_UNLIKELY(decoding)) {
        hn::StoreU(turn[k], d, row_.turn + pixel);
        hn::StoreU(doubt, d, row_.doubt + pixel);
        hn::StoreU(y, d, row_.unhidden_coordinate + pixel);
      }
      hn::StoreU(hn::IfThenElse(cannot_vote(square[k]), nans(), y), d, row_.coordinate + pixel);
    });
  }

 private:
  /// Whether the cue changes the mean, which is reported without it.
  static constexpr bool casts_shade = steps == 3;

  HWY_INLINE CueSums at(std::size_t i) const {
    return cue_sums<steps>(stage_, cue_, steps == 0 ? all_frames_ : frames_.data(), i);
  }
  HWY_INLINE FloatMask cannot_vote(Floats square) const {
    return hn::Lt(square, hn::Set(FloatTag(), row_.cue_limits.voting_square));
  }
  HWY_INLINE FloatMask is_dark_at(Floats square) const {
    return hn::Lt(square, hn::Set(FloatTag(), row_.limits.least_square));
  }

  /// Stores pixels that give no point and do not vote.
  HWY_INLINE void store_hidden(std::size_t i, Floats sum, Floats square) const {
    const FloatTag d;
    store_flags(i, square, hn::Zero(d), false);
    store(hn::Mul(sum, hn::Set(d, row_.limits.mean_scale)), row_.mean + i, row_.past_cache);
    hn::StoreU(nans(), d, row_.coordinate + i);
  }

  HWY_INLINE void store_flags(std::size_t i, Floats square, Floats doubt, bool saturated) const {
    const FloatTag d;
    Ints flags = hn::Or(
        flag_where(is_dark_at(square), PixelFlag::dark),
        hn::Or(
            flag_where(hn::Le(square, hn::Set(d, row_.cue_limits.lit_square)), PixelFlag::dim),
            flag_where(hn::Gt(doubt, hn::Set(d, cue_.largest_doubt)), PixelFlag::doubtful_order)));
    if (HWY_UNLIKELY(saturated))
      flags = hn::Or(flags, saturation_flag(row_.limits, at(i).high.greatest));
    hn::StoreU(flags, IntTag(), row_.flags + i);
  }

  HWY_INLINE Floats coordinate(Floats turns) const {
    if constexpr (is_circle<steps>) return in_field_(turns);
    return hn::Mul(turns, hn::Set(FloatTag(), cue_.coordinate.scale));
  }

  /// Mean without the contribution of the 3-step cue.
  HWY_INLINE Floats shown_mean(Floats sum, Floats modulation, Floats y) const {
    const FloatTag d;
    if constexpr (casts_shade) {
      const Floats one = hn::Set(d, 1.0F);
      const Floats R = hn::Clamp(hn::MulSub(hn::Set(d, 2.0F), y, one), hn::Neg(one), one);
      sum = hn::NegMulAdd(hn::Mul(modulation, hn::Set(d, 3 * cue_.shade)), R, sum);
    }
    return hn::Mul(sum, hn::Set(d, row_.limits.mean_scale));
  }

  const SinusoidStage& stage_;
  const CueStage& cue_;
  CueRow row_;
  const Pixel* const* all_frames_;
  std::array<const Pixel*, std::max(steps, 1)> frames_{};
  Saturation<Pixel> saturation_;
  FieldPlacer in_field_;
};

template <int steps, class Pixel>
HWY_INLINE void decode_steps(const SinusoidStage& stage, const CueStage& cue,
                             const Pixel* const* frames, const CueRow& row) {
  const CueVectors<steps, Pixel> vectors(stage, cue, frames, row);
  constexpr std::size_t most = is_circle<steps> ? few_at_once : at_once;
  for_each_group<most>(static_cast<std::size_t>(row.width),
                       [&]<std::size_t count>(Together<count>, std::size_t i)
                           SLIPSTREAM_STEP { vectors.template decode<count>(i); });
}

template <class Pixel>
HWY_NOINLINE void decode_cue(const SinusoidStage& stage, const CueStage& cue,
                             const Pixel* const* frames, const CueRow& row) {
  if (stage.steps == 3) return decode_steps<3>(stage, cue, frames, row);
  if (stage.steps == 4) return decode_steps<4>(stage, cue, frames, row);
  if (stage.steps == 5) return decode_steps<5>(stage, cue, frames, row);
  if (stage.steps == 6) return decode_steps<6>(stage, cue, frames, row);
  decode_steps<0>(stage, cue, frames, row);
}

void DecodeCueRow(const SinusoidStage& stage, const CueStage& cue, const FrameRows& frames,
                  const CueRow& row) {
  std::visit([&](auto of) { decode_cue(stage, cue, of, row); }, frames);
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(DecodeCueRow);

void decode_row(const SinusoidStage& stage, const CueStage& cue, const FrameRows& frames,
                const CueRow& row) {
  HWY_DYNAMIC_DISPATCH(DecodeCueRow)(stage, cue, frames, row);
}

}  // namespace slipstream
#endif
