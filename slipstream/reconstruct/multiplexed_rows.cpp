#include "slipstream/reconstruct/multiplexed_rows.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include "slipstream/reconstruct/disabled_targets-inl.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slipstream/reconstruct/multiplexed_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "slipstream/reconstruct/frame_sums-inl.h"
#include "slipstream/reconstruct/sinusoid_turns-inl.h"
#include "slipstream/reconstruct/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// The cue of N >= 5 is a sinusoid.
template <int steps>
constexpr bool is_circle = steps != 3 && steps != 4;

/// What one vector of pixels says: the high frequency, and the channel of the cue times N, or its
/// cosine and sine up to a factor.
struct MultiplexedSums {
  FrameSums high;
  Floats cue, cue_sine;
};

/// N = 6: the second channel in integers; U is 6 C, V 6 S / sqrt(3).
template <class Pixel>
HWY_INLINE MultiplexedSums sixth_sums(const Pixel* const* frames, std::size_t i) {
  const FloatTag d;
  const auto I = [&](std::size_t n) SLIPSTREAM_STEP { return load_pixels(frames[n] + i); };
  const Ints rising = hn::Add(I(1), I(4)), falling = hn::Add(I(2), I(5));
  const Ints U = hn::Sub(hn::ShiftLeft<1>(hn::Add(I(0), I(3))), hn::Add(rising, falling));
  return {closed_form_sums<6>(frames, i), hn::ConvertTo(d, U),
          hn::ConvertTo(d, hn::Sub(rising, falling))};
}

/// N above 6. Frames n and N - n have the same cosine and opposite sines: their sum and their
/// difference serve both channels.
template <class Pixel>
HWY_INLINE MultiplexedSums two_channel_sums(const SinusoidStage& stage, const CueStage& cue,
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
  return {{sum, greatest, C.sum(), S.sum()}, cue_C.sum(), cue_S.sum()};
}

/// `steps`: N where its sums are compiled, else 0.
template <int steps, class Pixel>
HWY_INLINE MultiplexedSums multiplexed_sums(const SinusoidStage& stage, const CueStage& cue,
                                            const Pixel* const* frames, std::size_t i) {
  const FloatTag d;
  if constexpr (steps == 3) {
    const FrameSums sums = closed_form_sums<3>(frames, i);
    return {sums, hn::ConvertTo(d, sums.sum), hn::Zero(d)};
  } else if constexpr (steps == 4) {
    const auto I = [&](std::size_t n) SLIPSTREAM_STEP { return load_pixels(frames[n] + i); };
    const Ints half_phase = hn::Sub(hn::Add(I(0), I(2)), hn::Add(I(1), I(3)));  // (3.70)
    return {closed_form_sums<4>(frames, i), hn::ConvertTo(d, half_phase), hn::Zero(d)};
  } else if constexpr (steps == 5) {
    const FifthSums sums = fifth_sums(frames, i);
    return {sums.first, sums.U, sums.V};
  } else if constexpr (steps == 6) {
    return sixth_sums(frames, i);
  } else {
    return two_channel_sums(stage, cue, frames, i);
  }
}

/// MultiplexedCue::coordinate, in periods of the high frequency. `modulation`: B_1^c.
template <int steps>
HWY_INLINE Floats cue_periods(const CueStage& cue, const CueLimits& limits,
                              const MultiplexedSums& sums, Floats modulation) {
  const FloatTag d;
  const Floats one = hn::Set(d, 1.0F), f_h = hn::Set(d, cue.periods);
  if constexpr (is_circle<steps>) {
    const Floats sine = hn::Mul(hn::Set(d, cue.sine_weight), sums.cue_sine);
    return hn::Mul(f_h, angle_in_turns(sine, sums.cue));  // (3.88)
  } else {
    constexpr bool mean = steps == 3;
    const Floats value =
        hn::MulSub(sums.cue, hn::Set(d, mean ? 1.0F / 3 : 1.0F / 4), hn::Set(d, limits.ambient));
    const auto has_light = hn::Gt(modulation, hn::Set(d, 1e-9F));
    const Floats ratio = quotient(value, hn::Max(modulation, hn::Set(d, 1e-9F)));
    const Floats R = hn::MulSub(hn::Set(d, cue.gain), ratio, hn::Set(d, cue.offset));
    const Floats held = hn::Clamp(R, hn::Neg(one), one);
    if constexpr (mean) {
      const Floats half = hn::Mul(f_h, hn::Set(d, 0.5F));
      return hn::IfThenElseZero(has_light, hn::MulAdd(held, half, half));
    } else {
      const Floats sine = hn::Sqrt(hn::Max(hn::NegMulAdd(held, held, one), hn::Zero(d)));
      const Floats turns = angle_in_turns(sine, held);
      return hn::IfThenElseZero(has_light, hn::Mul(hn::Add(f_h, f_h), turns));
    }
  }
}

/// In [0, 1).
HWY_INLINE Floats within_a_turn(Floats turn) {
  const Floats part = hn::Sub(turn, hn::Floor(turn));
  return hn::IfThenElseZero(hn::Lt(part, hn::Set(FloatTag(), 1.0F)), part);
}

/// What the kernel takes, without the lists.
struct MultiplexedWork {
  const SinusoidStage& stage;
  const CueStage& cue;
  SinusoidLimits limits;
  CueLimits cue_limits;
  MultiplexedRow row;
};

/// MultiplexedCue::nearest_order.
template <int steps>
HWY_INLINE Floats nearest_order(const CueStage& cue, Floats periods) {
  const FloatTag d;
  const Floats k = hn::Round(periods);
  if constexpr (is_circle<steps>) return k;
  return hn::Clamp(k, hn::Zero(d), hn::Set(d, cue.periods - 1));
}

/// One row, vector by vector. Members are copies, which no store can change.
template <int steps, class Pixel>
class MultiplexedVectors {
 public:
  HWY_INLINE MultiplexedVectors(const MultiplexedWork& work, const Pixel* const* frames)
      : stage_(work.stage),
        cue_(work.cue),
        limits_(work.limits),
        cue_limits_(work.cue_limits),
        row_(work.row),
        all_frames_(frames),
        in_field_(work.cue.coordinate) {
    std::copy_n(frames, steps, frames_.begin());
  }

  HWY_INLINE void operator()(std::size_t i) const {
    const FloatTag d;
    const IntTag di;
    const MultiplexedSums sums =
        multiplexed_sums<steps>(stage_, cue_, steps == 0 ? all_frames_ : frames_.data(), i);
    // On the circle a whole turn more or less leads to the same place.
    Floats turn = corrected_turn(stage_, sums.high);
    if constexpr (!is_circle<steps>) turn = within_a_turn(turn);
    const Floats square = modulation_square(stage_, sums.high);
    const bool decoding = row_.turn != nullptr;
    Floats modulation = square;  // of no use where it is not asked for
    if (!is_circle<steps> || decoding) {
      modulation = hn::Mul(hn::Sqrt(square), hn::Set(d, stage_.modulation_scale));
    }
    const Floats periods = hn::Sub(cue_periods<steps>(cue_, cue_limits_, sums, modulation), turn);
    const Floats k = nearest_order<steps>(cue_, periods);
    const Floats y = coordinate(hn::Add(turn, k));
    Floats doubt = hn::Abs(hn::Sub(periods, k));
    if constexpr (!is_circle<steps>) doubt = hn::Min(doubt, hn::Set(d, 0.5F));

    const auto is_dim = hn::Le(square, hn::Set(d, cue_limits_.lit_square));
    const auto is_doubtful = hn::Gt(doubt, hn::Set(d, cue_.largest_doubt));
    const Ints flags =
        hn::Or(exposure_flags(limits_, sums.high, square),
               hn::Or(hn::IfThenElseZero(hn::RebindMask(di, is_dim), hn::Set(di, PixelFlag::dim)),
                      hn::IfThenElseZero(hn::RebindMask(di, is_doubtful),
                                         hn::Set(di, PixelFlag::doubtful_order))));
    hn::StoreU(flags, di, row_.flags + i);
    store(mean(sums.high, modulation, y), row_.mean + i, row_.past_cache);
    if (HWY_UNLIKELY(decoding)) {
      hn::StoreU(turn, d, row_.turn + i);
      hn::StoreU(modulation, d, row_.modulation + i);
      hn::StoreU(doubt, d, row_.doubt + i);
      hn::StoreU(y, d, row_.unhidden_coordinate + i);
    }
    const auto is_nobody = hn::Lt(square, hn::Set(d, cue_limits_.voting_square));
    const Floats nan = hn::Set(d, std::numeric_limits<float>::quiet_NaN());
    hn::StoreU(hn::IfThenElse(is_nobody, nan, y), d, row_.coordinate + i);
  }

 private:
  HWY_INLINE Floats coordinate(Floats turns) const {
    if constexpr (is_circle<steps>) return in_field_(turns);
    return hn::Mul(turns, hn::Set(FloatTag(), cue_.coordinate.scale));
  }

  /// Less the shade that the cue of 3 steps casts on it.
  HWY_INLINE Floats mean(const FrameSums& sums, Floats modulation, Floats y) const {
    const FloatTag d;
    Floats sum = hn::ConvertTo(d, sums.sum);
    if constexpr (steps == 3) {
      const Floats one = hn::Set(d, 1.0F);
      const Floats R = hn::Clamp(hn::MulSub(hn::Set(d, 2.0F), y, one), hn::Neg(one), one);
      sum = hn::NegMulAdd(hn::Mul(modulation, hn::Set(d, 3 * cue_.shade)), R, sum);
    }
    return hn::Mul(sum, hn::Set(d, limits_.mean_scale));
  }

  const SinusoidStage& stage_;
  const CueStage& cue_;
  SinusoidLimits limits_;
  CueLimits cue_limits_;
  MultiplexedRow row_;
  const Pixel* const* all_frames_;
  std::array<const Pixel*, std::max(steps, 1)> frames_{};
  FieldPlacer in_field_;
};

template <int steps, class Pixel>
HWY_INLINE void decode_steps(const MultiplexedWork& work, const Pixel* const* frames) {
  const MultiplexedVectors<steps, Pixel> vectors(work, frames);
  for_each_vector(work.row.width, vectors);
}

template <class Pixel>
HWY_INLINE void decode_multiplexed(const MultiplexedWork& work, const Pixel* const* frames) {
  switch (work.stage.steps) {
    case 3:
      return decode_steps<3>(work, frames);
    case 4:
      return decode_steps<4>(work, frames);
    case 5:
      return decode_steps<5>(work, frames);
    case 6:
      return decode_steps<6>(work, frames);
    default:
      return decode_steps<0>(work, frames);
  }
}

void DecodeMultiplexedRow8(const SinusoidStage& stage, const CueStage& cue,
                           const SinusoidLimits& limits, const CueLimits& cue_limits,
                           const std::uint8_t* const* frames, const MultiplexedRow& row) {
  decode_multiplexed({stage, cue, limits, cue_limits, row}, frames);
}

void DecodeMultiplexedRow16(const SinusoidStage& stage, const CueStage& cue,
                            const SinusoidLimits& limits, const CueLimits& cue_limits,
                            const std::uint16_t* const* frames, const MultiplexedRow& row) {
  decode_multiplexed({stage, cue, limits, cue_limits, row}, frames);
}

void FindDisagreeing(const CueStage& cue, const CoordinateRows& rows,
                     std::vector<PixelPlace>& found) {
  const FloatTag d;
  // A little less and more than the vote's own limits, whose numbers are not rounded to float.
  const Floats half_period = hn::Set(d, 0.499F / cue.periods);
  const Floats steepest = hn::Set(d, 0.251F);
  const Floats f_h = hn::Set(d, cue.periods);
  const auto lanes = static_cast<int>(hn::Lanes(d));
  for (int next = 0; next < rows.width; next += lanes) {
    const int i = std::min(next, rows.width - lanes);
    const Floats y = hn::LoadU(d, rows.here + i);
    const auto far = [&](const float* other) SLIPSTREAM_STEP {
      return hn::Gt(hn::Abs(hn::Sub(hn::LoadU(d, other + i), y)), half_period);
    };
    const auto any = hn::Or(hn::Or(far(rows.here - 1), far(rows.here + 1)),
                            hn::Or(far(rows.above), far(rows.below)));
    if (HWY_LIKELY(hn::AllFalse(d, any))) continue;
    // A step of whole periods, but for one that may be the surface's own.
    const auto disagrees = [&](const float* other) SLIPSTREAM_STEP {
      const Floats periods = hn::Mul(hn::Sub(hn::LoadU(d, other + i), y), f_h);
      const Floats part = hn::Abs(hn::Sub(periods, hn::Round(periods)));
      return hn::And(far(other), hn::Le(part, steepest));
    };
    const auto open = hn::Or(hn::Or(disagrees(rows.here - 1), disagrees(rows.here + 1)),
                             hn::Or(disagrees(rows.above), disagrees(rows.below)));
    if (hn::AllFalse(d, open)) continue;
    HWY_ALIGN std::array<std::int32_t, HWY_MAX_BYTES / 4> lane;
    const IntTag di;
    hn::Store(hn::VecFromMask(di, hn::RebindMask(di, open)), di, lane.data());
    for (int j = next - i; j < lanes; ++j) {
      if (lane[static_cast<std::size_t>(j)] != 0) found.push_back({rows.row, i + j});
    }
  }
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(DecodeMultiplexedRow8);
HWY_EXPORT(DecodeMultiplexedRow16);
HWY_EXPORT(FindDisagreeing);

void decode_row(const SinusoidStage& stage, const CueStage& cue, const SinusoidLimits& limits,
                const CueLimits& cue_limits, const std::uint8_t* const* frames,
                const MultiplexedRow& row) {
  HWY_DYNAMIC_DISPATCH(DecodeMultiplexedRow8)(stage, cue, limits, cue_limits, frames, row);
}

void decode_row(const SinusoidStage& stage, const CueStage& cue, const SinusoidLimits& limits,
                const CueLimits& cue_limits, const std::uint16_t* const* frames,
                const MultiplexedRow& row) {
  HWY_DYNAMIC_DISPATCH(DecodeMultiplexedRow16)(stage, cue, limits, cue_limits, frames, row);
}

void find_disagreeing(const CueStage& cue, const CoordinateRows& rows,
                      std::vector<PixelPlace>& found) {
  HWY_DYNAMIC_DISPATCH(FindDisagreeing)(cue, rows, found);
}

}  // namespace slipstream
#endif
