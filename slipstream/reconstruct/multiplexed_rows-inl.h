// Frames with a cue in them to coordinates. Included once for each vector target, see
// fused_rows.cpp.
#if defined(SLIPSTREAM_RECONSTRUCT_MULTIPLEXED_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SLIPSTREAM_RECONSTRUCT_MULTIPLEXED_ROWS_INL_H_
#undef SLIPSTREAM_RECONSTRUCT_MULTIPLEXED_ROWS_INL_H_
#else
#define SLIPSTREAM_RECONSTRUCT_MULTIPLEXED_ROWS_INL_H_
#endif

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <vector>

#include <hwy/highway.h>

#include "slipstream/reconstruct/multiplexed_rows.h"
#include "slipstream/reconstruct/sinusoid_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// What one vector of pixels says: the high frequency, and the channel of the cue times N, or its
/// cosine and sine.
struct MultiplexedSums {
  FrameSums high;
  Floats cue, cue_sine;
};

/// N >= 5. Frames n and N - n have the same cosine and opposite sines: their sum and their
/// difference, exact in integers, serve both channels.
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

template <CueStage::Channel channel, class Pixel>
HWY_INLINE MultiplexedSums multiplexed_sums(const SinusoidStage& stage, const CueStage& cue,
                                            const Pixel* const* frames, std::size_t i) {
  const FloatTag d;
  if constexpr (channel == CueStage::Channel::mean) {
    const FrameSums sums = closed_form_sums<3>(frames, i);
    return {sums, hn::ConvertTo(d, sums.sum), hn::Zero(d)};
  } else if constexpr (channel == CueStage::Channel::half_phase) {
    const auto I = [&](std::size_t n) HWY_ATTR { return load_pixels(frames[n] + i); };
    const Ints half_phase = hn::Sub(hn::Add(I(0), I(2)), hn::Add(I(1), I(3)));  // (3.70)
    return {closed_form_sums<4>(frames, i), hn::ConvertTo(d, half_phase), hn::Zero(d)};
  } else {
    return two_channel_sums(stage, cue, frames, i);
  }
}

/// MultiplexedCue::coordinate, in periods of the high frequency. `modulation`: B_1^c.
template <CueStage::Channel channel>
HWY_INLINE Floats cue_periods(const CueStage& cue, const CueLimits& limits,
                              const MultiplexedSums& sums, Floats modulation) {
  const FloatTag d;
  const Floats one = hn::Set(d, 1.0F), f_h = hn::Set(d, cue.periods);
  if constexpr (channel == CueStage::Channel::second) {
    return hn::Mul(f_h, angle_in_turns(sums.cue_sine, sums.cue));  // (3.88)
  } else {
    constexpr bool mean = channel == CueStage::Channel::mean;
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

/// Everything of one row that does not change from vector to vector.
struct MultiplexedWork {
  const SinusoidStage& stage;
  const CueStage& cue;
  const SinusoidLimits& limits;
  const CueLimits& cue_limits;
  const MultiplexedRow& row;
};

/// MultiplexedCue::nearest_order.
template <CueStage::Channel channel>
HWY_INLINE Floats nearest_order(const CueStage& cue, Floats periods) {
  const FloatTag d;
  const Floats k = hn::Round(periods);
  if constexpr (channel == CueStage::Channel::second) return k;
  return hn::Clamp(k, hn::Zero(d), hn::Set(d, cue.periods - 1));
}

/// The mean less the shade that the cue of 3 steps casts
/// on it.
template <CueStage::Channel channel>
HWY_INLINE Floats mean_of(const MultiplexedWork& work, const FrameSums& sums, Floats modulation,
                          Floats y) {
  const FloatTag d;
  Floats sum = hn::ConvertTo(d, sums.sum);
  if constexpr (channel == CueStage::Channel::mean) {
    const Floats one = hn::Set(d, 1.0F);
    const Floats R = hn::Clamp(hn::MulSub(hn::Set(d, 2.0F), y, one), hn::Neg(one), one);
    const Floats scale = hn::Mul(modulation, hn::Set(d, 3 * work.cue.shade));
    sum = hn::NegMulAdd(scale, R, sum);
  }
  return hn::Mul(sum, hn::Set(d, work.limits.mean_scale));
}

template <CueStage::Channel channel>
HWY_INLINE void store_multiplexed(const MultiplexedWork& work, const FieldPlacer& in_field,
                                  const MultiplexedSums& sums, std::size_t i) {
  using Channel = CueStage::Channel;
  const FloatTag d;
  const IntTag di;
  const auto& [stage, cue, limits, cue_limits, row] = work;
  const Floats turn = within_a_turn(corrected_turn(stage, sums.high));
  const Floats square = modulation_square(stage, sums.high);
  const bool decoding = row.turn != nullptr;
  Floats modulation = square;  // of no use where it is not asked for
  if (channel != Channel::second || decoding) {
    modulation = hn::Mul(hn::Sqrt(square), hn::Set(d, stage.modulation_scale));
  }

  const Floats periods = hn::Sub(cue_periods<channel>(cue, cue_limits, sums, modulation), turn);
  const Floats k = nearest_order<channel>(cue, periods);
  Floats y = hn::Add(turn, k);
  if constexpr (channel == Channel::second) {
    y = in_field(y);
  } else {
    y = hn::Mul(y, hn::Set(d, cue.coordinate.scale));
  }
  const Floats doubt = hn::Min(hn::Abs(hn::Sub(periods, k)), hn::Set(d, 0.5F));

  const Ints exposure = exposure_flags(limits, sums.high, square);
  const auto flag_where = [di](auto mask, PixelFlag flag) HWY_ATTR {
    return hn::IfThenElseZero(hn::RebindMask(di, mask), hn::Set(di, flag));
  };
  const auto is_dim = hn::Le(square, hn::Set(d, cue_limits.lit_square));
  const auto is_doubtful = hn::Gt(doubt, hn::Set(d, cue.largest_doubt));
  const Ints flags = hn::Or(exposure, hn::Or(flag_where(is_dim, PixelFlag::dim),
                                             flag_where(is_doubtful, PixelFlag::doubtful_order)));
  const hn::Rebind<std::uint8_t, IntTag> bytes;
  hn::StoreU(hn::DemoteTo(bytes, flags), bytes, row.flags + i);

  store(mean_of<channel>(work, sums.high, modulation, y), row.mean + i, row.past_cache);
  if (decoding) {
    hn::StoreU(turn, d, row.turn + i);
    hn::StoreU(modulation, d, row.modulation + i);
    hn::StoreU(doubt, d, row.doubt + i);
    hn::StoreU(y, d, row.unhidden_coordinate + i);
  }
  const Ints both = hn::Set(di, PixelFlag::dark | PixelFlag::dim);
  const auto hidden = hn::RebindMask(d, hn::Eq(hn::And(flags, both), both));
  const Floats nan = hn::Set(d, std::numeric_limits<float>::quiet_NaN());
  hn::StoreU(hn::IfThenElse(hidden, nan, y), d, row.coordinate + i);
}

template <CueStage::Channel channel, class Pixel>
HWY_INLINE void decode_channel(const MultiplexedWork& work, const Pixel* const* frames) {
  const FieldPlacer in_field(work.cue.coordinate);
  for_each_vector(work.row.width, [&](std::size_t i) HWY_ATTR {
    store_multiplexed<channel>(work, in_field,
                               multiplexed_sums<channel>(work.stage, work.cue, frames, i), i);
  });
}

template <class Pixel>
HWY_INLINE void decode_multiplexed(const MultiplexedWork& work, const Pixel* const* frames) {
  switch (work.cue.channel) {
    case CueStage::Channel::mean:
      return decode_channel<CueStage::Channel::mean>(work, frames);
    case CueStage::Channel::half_phase:
      return decode_channel<CueStage::Channel::half_phase>(work, frames);
    case CueStage::Channel::second:
      return decode_channel<CueStage::Channel::second>(work, frames);
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
    const auto far = [&](const float* other) HWY_ATTR {
      return hn::Gt(hn::Abs(hn::Sub(hn::LoadU(d, other + i), y)), half_period);
    };
    const auto any = hn::Or(hn::Or(far(rows.here - 1), far(rows.here + 1)),
                            hn::Or(far(rows.above), far(rows.below)));
    if (HWY_LIKELY(hn::AllFalse(d, any))) continue;
    // A step of whole periods, but for one that may be the surface's own.
    const auto disagrees = [&](const float* other) HWY_ATTR {
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

void TakeRow(int width, const float* coordinates, const std::uint8_t* flags, float* taken,
             std::int32_t* taken_flags) {
  const FloatTag d;
  const IntTag di;
  const Floats nan = hn::Set(d, std::numeric_limits<float>::quiet_NaN());
  for_each_vector(width, [&](std::size_t i) HWY_ATTR {
    const Ints flag = load_pixels(flags + i);
    const auto is_dark = hn::Ne(hn::And(flag, hn::Set(di, PixelFlag::dark)), hn::Zero(di));
    hn::StoreU(hn::IfThenElse(hn::RebindMask(d, is_dark), nan, hn::LoadU(d, coordinates + i)), d,
               taken + i);
    hn::StoreU(flag, di, taken_flags + i);
  });
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
