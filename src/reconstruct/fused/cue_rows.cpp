// Coordinates of a row from frames with a cue.

#include "reconstruct/fused/cue_rows.h"

#include <algorithm>
#include <array>
#include <variant>

#include "reconstruct/fused/sinusoid_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "reconstruct/fused/cue_rows.cpp"
#include <hwy/foreach_target.h>

#include "base/vectors-inl.h"
#include "reconstruct/fused/sinusoid_sums-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// In place of N, for sums with weights: see CueStage::Sums.
constexpr int mirrored_weights = 0, any_weights = -1;

/// Sums of a vector of pixels: of the measuring band, and of the cue's channel, or the cue's cosine
/// and sine, up to a factor.
struct CueSums {
  FrameSums high;
  Floats cue, cue_sine;
};

/// Sum and difference of frames n and N - n, of opposite sines, serve both channels.
template <class Pixel>
HWY_INLINE CueSums two_channel_sums(const SinusoidStage& stage, const CueStage& cue,
                                    const Pixel* const* frames, std::size_t i) {
  // Frame 0 has no sine.
  const Ints first = load_pixels(frames[0] + i);
  Ints sum = first, greatest = first;
  DoubleSums C, S, cue_C, cue_S;
  C.add(first, stage.cosines[0]);
  cue_C.add(first, cue.cosines[0]);

  // Then the frames in pairs.
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

  // With an even N, the frame half way round has no sine either.
  if (N % 2 == 0) {
    const Ints middle = load_pixels(frames[N / 2] + i);
    sum = hn::Add(sum, middle);
    greatest = hn::Max(greatest, middle);
    C.add(middle, stage.cosines[N / 2]);
    cue_C.add(middle, cue.cosines[N / 2]);
  }

  return {{hn::ConvertTo(FloatTag(), sum), greatest, C.sum(), S.sum()}, cue_C.sum(), cue_S.sum()};
}

template <class Pixel>
HWY_INLINE CueSums any_sums(const SinusoidStage& stage, const CueStage& cue,
                            const Pixel* const* frames, std::size_t i) {
  DoubleSums C, S;

  for (std::size_t n = 0; n < cue.cosines.size(); ++n) {
    const Ints I = load_pixels(frames[n] + i);
    C.add(I, cue.cosines[n]);
    S.add(I, cue.sines[n]);
  }

  return {stage.whole.empty() ? general_sums(stage, frames, i)
                              : whole_sums<Pixel>(stage.whole, frames, i),
          C.sum(), S.sum()};
}

/// `steps`: N if its sums are compiled, else one of the constants above.
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
  } else if constexpr (steps == mirrored_weights) {
    return two_channel_sums(stage, cue, frames, i);
  } else {
    return any_sums(stage, cue, frames, i);
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

/// CueEvidence::coordinate, in periods of the high frequency, from the cue's channel, its sine on
/// the circle, and B_1^c; without light 0 unless on the circle.
template <CueForm form, std::size_t count>
HWY_INLINE Several<count> cue_periods(const CueStage& cue, const CueLimits& limits,
                                      const Several<count>& channel, Several<count> sine,
                                      const Several<count>& modulation) {
  const FloatTag d;
  Several<count> R, periods;

  if constexpr (form == CueForm::circle) {
    const Floats weight = hn::Set(d, cue.sine_weight);
    each<count>([&](std::size_t k) SLIPSTREAM_STEP { sine[k] = hn::Mul(weight, sine[k]); });
    return angles_times(cue.periods, sine, channel);  // (3.88)
  }

  // R from the channel and the modulation, which removes the surface's reflectivity.
  const Floats one = hn::Set(d, 1.0F), least = hn::Set(d, 1e-9F);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    const Floats value =
        hn::MulSub(channel[k], hn::Set(d, cue.channel_scale), hn::Set(d, limits.ambient));
    const Floats ratio = quotient(value, hn::Max(modulation[k], least));
    R[k] = hn::Clamp(hn::MulSub(hn::Set(d, cue.gain), ratio, hn::Set(d, cue.offset)), hn::Neg(one),
                     one);
  });

  // From R to the coordinate: (R + 1) / 2, or the angle of cos(pi y), which is y / 2 turns.
  if constexpr (form == CueForm::linear) {
    const Floats half = hn::Set(d, 0.5F * cue.periods);
    each<count>([&](std::size_t k) SLIPSTREAM_STEP { periods[k] = hn::MulAdd(R[k], half, half); });
  } else {
    each<count>([&](std::size_t k) SLIPSTREAM_STEP {
      sine[k] = hn::Sqrt(hn::Max(hn::NegMulAdd(R[k], R[k], one), hn::Zero(d)));
    });
    periods = angles_times(2 * cue.periods, sine, R);
  }

  // R is undefined in the dark.
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
template <CueForm form>
HWY_INLINE Floats nearest_order(const CueStage& cue, Floats periods) {
  const FloatTag d;
  const Floats k = hn::Round(periods);

  if constexpr (form == CueForm::circle) return k;
  return hn::Clamp(k, hn::Zero(d), hn::Set(d, cue.periods - 1));
}

/// Decodes one row. Members are copies, so that no store can alias them.
template <int steps, CueForm form, class Pixel>
class CueVectors {
 public:
  HWY_INLINE CueVectors(const SinusoidStage& stage, const CueStage& cue, const Pixel* const* frames,
                        const CueRow& row)
      : stage_(stage),
        cue_(cue),
        row_(row),
        all_frames_(frames),
        saturation_(has_weights ? frames : frames_.data(),
                    has_weights ? stage.cosines.size() : steps, row.limits.full_scale),
        in_field_(cue.coordinate) {
    if constexpr (!has_weights) std::copy_n(frames, steps, frames_.begin());
  }

  CueVectors(const CueVectors&) = delete;  // it points into itself
  CueVectors& operator=(const CueVectors&) = delete;
  ~CueVectors() = default;

  /// Decodes vectors from pixel `i` on.
  template <std::size_t count>
  HWY_INLINE void decode(std::size_t i) const {
    const FloatTag d;
    const bool wants_modulation = row_.modulation != nullptr;

    // 1. Sums of the frames, and the modulation where it is needed.
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
      if (!is_circle || wants_modulation) {
        modulation[k] = hn::Mul(hn::Sqrt(square[k]), hn::Set(d, stage_.modulation_scale));
      }
      if (wants_modulation) hn::StoreU(modulation[k], d, row_.modulation + i + k * hn::Lanes(d));
      all_hidden = hn::And(all_hidden, hn::And(cannot_vote(square[k]), is_dark_at(square[k])));
    });

    // 2. Often, as in shadows, no pixel can become a point or vote: skip the angles.
    if (!casts_shade() && !is_decoding() && hn::AllTrue(d, all_hidden)) {
      return each<count>([&](std::size_t k) SLIPSTREAM_STEP {
        store_hidden(i + k * hn::Lanes(d), sum[k], square[k]);
      });
    }

    // 3. The wrapped phase, and the cue's coordinate in periods. On the circle, whole turns make no
    // difference.
    Several<count> turn = without_shifts<count>(stage_, corrected_turns<count>(stage_, V, U));
    if constexpr (!is_circle) {
      each<count>([&](std::size_t k) SLIPSTREAM_STEP { turn[k] = within_a_turn(turn[k]); });
    }
    const Several<count> cue_place =
        cue_periods<form, count>(cue_, row_.cue_limits, channel, sine, modulation);

    // 4. The coordinates.
    const bool saturated = saturation_.template among<count>(i);
    each<count>([&](std::size_t k) SLIPSTREAM_STEP {
      store_pixels(i + k * hn::Lanes(d), sum[k], square[k], modulation[k], turn[k], cue_place[k],
                   saturated);
    });
  }

 private:
  static constexpr bool is_circle = form == CueForm::circle;
  static constexpr bool has_weights = steps == mirrored_weights || steps == any_weights;

  /// Whether more than points is wanted.
  HWY_INLINE bool is_decoding() const { return row_.turn != nullptr; }

  /// Stores a vector of pixels, at the fringe order nearest to the cue, with the distance from it
  /// as doubt.
  HWY_INLINE void store_pixels(std::size_t pixel, Floats sum, Floats square, Floats modulation,
                               Floats turn, Floats cue_place, bool saturated) const {
    const FloatTag d;
    const Floats periods = hn::Sub(cue_place, turn);
    const Floats order = nearest_order<form>(cue_, periods);
    const Floats y = coordinate(hn::Add(turn, order));

    Floats doubt = hn::Abs(hn::Sub(periods, order));
    if constexpr (!is_circle) doubt = hn::Min(doubt, hn::Set(d, 0.5F));

    store_flags(pixel, square, doubt, saturated);
    fetch_ahead(row_.mean + pixel, row_.past_cache);
    store(shown_mean(sum, modulation, y), row_.mean + pixel, row_.past_cache);

    if (HWY_UNLIKELY(is_decoding())) {
      hn::StoreU(turn, d, row_.turn + pixel);
      hn::StoreU(doubt, d, row_.doubt + pixel);
      hn::StoreU(y, d, row_.unhidden_coordinate + pixel);
    }

    hn::StoreU(hn::IfThenElse(cannot_vote(square), nans(), y), d, row_.coordinate + pixel);
  }

  /// Whether the cue changes the mean, which is reported without it.
  HWY_INLINE bool casts_shade() const {
    return steps == 3 || (steps == any_weights && cue_.shade != 0);
  }

  HWY_INLINE CueSums at(std::size_t i) const {
    return cue_sums<steps>(stage_, cue_, has_weights ? all_frames_ : frames_.data(), i);
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

    // Rare, so the frames are read again.
    if (HWY_UNLIKELY(saturated))
      flags = hn::Or(flags, saturation_flag(row_.limits, at(i).high.greatest));

    hn::StoreU(flags, IntTag(), row_.flags + i);
  }

  HWY_INLINE Floats coordinate(Floats turns) const {
    if constexpr (is_circle) return in_field_(turns);
    return hn::Mul(turns, hn::Set(FloatTag(), cue_.coordinate.scale));
  }

  /// Mean without the contribution of a cue in it.
  HWY_INLINE Floats shown_mean(Floats sum, Floats modulation, Floats y) const {
    const FloatTag d;
    if (casts_shade()) {
      // The reference R, of the modulation's size.
      const float shade = static_cast<float>(stage_.steps) * cue_.shade;
      const Floats R = cue_reference<form == CueForm::cosine>(y);
      sum = hn::NegMulAdd(hn::Mul(modulation, hn::Set(d, shade)), R, sum);
    }
    return hn::Mul(sum, hn::Set(d, row_.limits.mean_scale));
  }

  const SinusoidStage& stage_;
  const CueStage& cue_;
  CueRow row_;
  const Pixel* const* all_frames_;
  std::array<const Pixel*, std::max(steps, 1)> frames_{};  ///< copies, unless it has weights
  Saturation<Pixel> saturation_;
  FieldPlacer in_field_;
};

template <int steps, CueForm form, class Pixel>
HWY_INLINE void decode_steps(const SinusoidStage& stage, const CueStage& cue,
                             const Pixel* const* frames, const CueRow& row) {
  const CueVectors<steps, form, Pixel> vectors(stage, cue, frames, row);
  constexpr std::size_t most = form == CueForm::circle ? few_at_once : at_once;

  for_each_group<most>(static_cast<std::size_t>(row.width),
                       [&]<std::size_t count>(Together<count>, std::size_t i)
                           SLIPSTREAM_STEP { vectors.template decode<count>(i); });
}

template <class Pixel>
HWY_NOINLINE void decode_cue(const SinusoidStage& stage, const CueStage& cue,
                             const Pixel* const* frames, const CueRow& row) {
  using enum CueForm;
  const auto decode = [&]<int steps, CueForm form>() {
    decode_steps<steps, form>(stage, cue, frames, row);
  };

  if (cue.sums == CueStage::Sums::any) {
    if (cue.form == circle) return decode.template operator()<any_weights, circle>();
    if (cue.form == cosine) return decode.template operator()<any_weights, cosine>();
    return decode.template operator()<any_weights, linear>();
  }

  if (cue.sums == CueStage::Sums::mirrored) {
    return decode.template operator()<mirrored_weights, circle>();
  }

  // Closed sums: the form and N determine the kernel.
  if (cue.form == cosine) return decode.template operator()<4, cosine>();
  if (cue.form == circle && stage.steps == 5) return decode.template operator()<5, circle>();
  if (cue.form == circle) return decode.template operator()<6, circle>();
  if (stage.steps == 3) return decode.template operator()<3, linear>();
  if (stage.steps == 4) return decode.template operator()<4, linear>();
  decode.template operator()<6, linear>();
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
