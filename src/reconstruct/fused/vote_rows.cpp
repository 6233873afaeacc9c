// Finds pixels that disagree with their neighbours, and the costs of their other fringe orders.
#include "reconstruct/fused/vote_rows.h"

#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <variant>
#include <vector>

#include "reconstruct/fused/cue_rows.h"
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "reconstruct/fused/vote_rows.cpp"
#include <hwy/foreach_target.h>

#include "base/vectors-inl.h"
#include "reconstruct/fused/sinusoid_sums-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// One vector of pixels: B, and the cue's channel or its cosine and sine.
struct CueVector {
  Floats modulation, cue, cue_sine;
};

template <class Pixel>
HWY_INLINE CueVector cue_vector(const OrderCostStage& stage, float to_8_bits,
                                const Pixel* const* frames, std::size_t i) {
  const FloatTag d;
  Floats C = hn::Zero(d), S = C, cue = C, cue_sine = C;

  for (std::size_t n = 0; n < stage.cosines.size(); ++n) {
    const Floats I = hn::Mul(hn::Set(d, to_8_bits), hn::ConvertTo(d, load_pixels(frames[n] + i)));
    const auto weight = [d](double of)
                            SLIPSTREAM_STEP { return hn::Set(d, static_cast<float>(of)); };

    C = hn::MulAdd(I, weight(stage.cosines[n]), C);
    S = hn::MulAdd(I, weight(stage.sines[n]), S);
    cue = hn::MulAdd(I, weight(stage.cue[n]), cue);
    cue_sine = hn::MulAdd(I, weight(stage.cue_sine[n]), cue_sine);
  }

  return {hn::Sqrt(hn::MulAdd(C, C, hn::Mul(S, S))), cue, cue_sine};
}

/// Cost for a cue that is a sinusoid of one period: its projection on the direction of y. The loss
/// from turning that direction is computed directly, because it is small.
class CircleCost {
 public:
  HWY_INLINE CircleCost(const OrderCostStage& stage, const CueVector& pixel, Floats y)
      : stage_(stage) {
    const FloatTag d;
    const Floats angle = hn::Mul(y, hn::Set(d, static_cast<float>(2 * std::numbers::pi)));
    const Floats cosine = hn::Cos(d, angle), sine = hn::Sin(d, angle);

    along_ = hn::MulAdd(pixel.cue, cosine, hn::Mul(pixel.cue_sine, sine));
    across_ = hn::MulSub(pixel.cue_sine, cosine, hn::Mul(pixel.cue, sine));

    own_ = hn::MulAdd(hn::Set(d, stage.share), pixel.modulation,
                      hn::Mul(hn::Set(d, stage.cue_share), along_));
  }

  HWY_INLINE Floats operator()(Floats, int shift) const {
    const FloatTag d;

    // The shift turns the direction of y. By `lost`, the projection c1 B + c2 along becomes
    // shorter.
    const double turn = 2 * std::numbers::pi * shift / stage_.periods;
    const auto sine = static_cast<float>(std::sin(turn));
    const auto versine = static_cast<float>(1 - std::cos(turn));

    const float c1 = stage_.share, c2 = stage_.cue_share;
    const Floats lost = hn::Mul(hn::Set(d, c2), hn::MulSub(hn::Set(d, versine), along_,
                                                           hn::Mul(hn::Set(d, sine), across_)));

    // A negative projection counts as 0. The difference of squares is (own - held) (own + held).
    const Floats zero = hn::Zero(d), other = hn::Sub(own_, lost);
    const Floats own = hn::Max(zero, own_), held = hn::Max(zero, other);
    const Floats less =
        hn::IfThenElse(hn::And(hn::Gt(own_, zero), hn::Gt(other, zero)), lost, hn::Sub(own, held));

    const float weight = 1 / ((c1 * c1 + c2 * c2) * stage_.component_variance);
    return hn::Mul(hn::Set(d, weight), hn::Mul(less, hn::Add(own, held)));
  }

 private:
  const OrderCostStage& stage_;
  Floats along_, across_, own_;
};

/// Cost for a cue in one channel, whose reference is a cosine or linear.
template <bool cosine>
class ReferenceCost {
 public:
  HWY_INLINE ReferenceCost(const OrderCostStage& stage, const CueVector& pixel, Floats y)
      : stage_(stage), pixel_(pixel), own_(terms(y)) {}

  HWY_INLINE Floats operator()(Floats y, int) const {
    const FloatTag d;
    const Terms other = terms(y);
    return hn::Add(hn::Sub(other.square, own_.square),
                   hn::Log(d, quotient(other.spread, own_.spread)));
  }

 private:
  struct Terms {
    Floats square, spread;
  };

  HWY_INLINE Terms terms(Floats y) const {
    const FloatTag d;
    const auto of = [d](float value) SLIPSTREAM_STEP { return hn::Set(d, value); };

    const Floats R = cue_reference<cosine>(y);

    // The cue's channel should be `slope` times B. The spread is the noise of their difference,
    // relative to the channel's own.
    const Floats slope = hn::MulAdd(of(stage_.cue_share / stage_.share), R, of(stage_.steady));
    const Floats difference =
        hn::NegMulAdd(slope, pixel_.modulation, hn::Sub(pixel_.cue, of(stage_.constant_light)));
    const Floats spread = hn::MulAdd(of(stage_.component_variance / stage_.cue_variance),
                                     hn::Mul(slope, slope), of(1));

    return {quotient(hn::Mul(difference, difference), hn::Mul(of(stage_.cue_variance), spread)),
            spread};
  }

  const OrderCostStage& stage_;
  const CueVector& pixel_;
  Terms own_;
};

template <class Cost, class Pixel>
HWY_INLINE void costs_of(const OrderCostStage& stage, float to_8_bits, const Pixel* const* frames,
                         const float* coordinate, const OrderCosts& costs) {
  const FloatTag d;
  const Floats period = hn::Set(d, 1 / stage.periods);
  const Floats least = hn::Set(d, -stage.margin), most = hn::Set(d, 1 + stage.margin);

  for (std::size_t i = 0; i < costed_together; i += hn::Lanes(d)) {
    const Floats y = hn::LoadU(d, coordinate + i);
    const CueVector pixel = cue_vector(stage, to_8_bits, frames, i);
    const Cost cost(stage, pixel, y);

    // An order that leaves the field, with its margin, is excluded.
    const auto held = [&](Floats place, int shift) SLIPSTREAM_STEP {
      const auto near_field = hn::And(hn::Ge(place, least), hn::Le(place, most));
      return hn::IfThenElse(near_field, cost(place, shift),
                            hn::Set(d, std::numeric_limits<float>::infinity()));
    };

    for (std::size_t k = 0; k < order_shifts.size(); ++k) {
      const int shift = order_shifts[k];
      const Floats place = hn::MulAdd(hn::Set(d, static_cast<float>(shift)), period, y);
      hn::StoreU(held(place, shift), d, costs[k] + i);
    }
  }
}

template <class Pixel>
HWY_NOINLINE void costs_by_form(const OrderCostStage& stage, float to_8_bits,
                                const Pixel* const* frames, const float* coordinate,
                                const OrderCosts& costs) {
  if (stage.form == CueForm::circle) {
    return costs_of<CircleCost>(stage, to_8_bits, frames, coordinate, costs);
  }
  if (stage.form == CueForm::cosine) {
    return costs_of<ReferenceCost<true>>(stage, to_8_bits, frames, coordinate, costs);
  }
  costs_of<ReferenceCost<false>>(stage, to_8_bits, frames, coordinate, costs);
}

void CostsOfOrders(const OrderCostStage& stage, float to_8_bits, const FrameRows& frames,
                   const float* coordinate, const OrderCosts& costs) {
  std::visit([&](auto of) { costs_by_form(stage, to_8_bits, of, coordinate, costs); }, frames);
}

/// Reads byte by byte: a wider load would wait for the narrower store before it.
HWY_INLINE std::uint32_t bits_of(FloatMask mask) {
  std::array<std::uint8_t, 8> bytes{};
  hn::StoreMaskBits(FloatTag(), mask, bytes.data());
  return bytes[0] | std::uint32_t{bytes[1]} << 8;
}

/// Searches one vector, from pixel i on.
HWY_INLINE void append_disagreeing(const CueStage& cue, const CoordinateRows& rows, int i,
                                   std::vector<PixelPlace>& found) {
  const FloatTag d;
  // Slightly wider than the vote's own limits, which are not rounded to float.
  const Floats half_period = hn::Set(d, 0.499F / cue.periods);
  const Floats steepest = hn::Set(d, 0.251F);
  const Floats f_h = hn::Set(d, cue.periods), y = hn::LoadU(d, rows.here + i);

  // True for a step of about one or more whole periods.
  const auto disagrees = [&](const float* other) SLIPSTREAM_STEP {
    const Floats step = hn::Sub(hn::LoadU(d, other + i), y), periods = hn::Mul(step, f_h);
    const Floats part = hn::Abs(hn::Sub(periods, hn::Round(periods)));
    return hn::And(hn::Gt(hn::Abs(step), half_period), hn::Le(part, steepest));
  };

  const auto open = hn::Or(hn::Or(disagrees(rows.here - 1), disagrees(rows.here + 1)),
                           hn::Or(disagrees(rows.above), disagrees(rows.below)));

  for (std::uint32_t bits = bits_of(open); bits != 0; bits &= bits - 1) {
    found.push_back({rows.row, i + std::countr_zero(bits)});
  }
}

/// Compares most vectors only with pixels to the left and below: a large step on the right is one
/// on the left of the next vector, and a large step above was one below.
void FindDisagreeing(const CueStage& cue, const CoordinateRows& rows,
                     std::vector<PixelPlace>& found) {
  const FloatTag d;
  const Floats half_period = hn::Set(d, 0.499F / cue.periods);
  const auto lanes = static_cast<int>(hn::Lanes(d));
  const CoordinateRows local = rows;  // a copy, so that no store can alias it

  std::uint8_t* far_above = local.far_above;
  bool far_before = false;
  for (int i = 0; i < local.width; i += lanes) {
    const Floats y = hn::LoadU(d, local.here + i);

    const auto far = [&](const float* other) SLIPSTREAM_STEP {
      return hn::Gt(hn::Abs(hn::Sub(hn::LoadU(d, other + i), y)), half_period);
    };
    const FloatMask left = far(local.here - 1);
    const bool below = !hn::AllFalse(d, far(local.below)), beside = !hn::AllFalse(d, left);

    // The vector before is complete only now that the pixel to its right is known.
    if (far_before || (beside && (bits_of(left) & 1U) != 0)) {
      append_disagreeing(cue, local, i - lanes, found);
    }

    far_before = beside || below || *far_above != 0;
    *far_above++ = below ? 1 : 0;
  }

  if (far_before) append_disagreeing(cue, local, (local.width - 1) / lanes * lanes, found);
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(CostsOfOrders);
HWY_EXPORT(FindDisagreeing);

void order_costs(const OrderCostStage& stage, float to_8_bits, const FrameRows& frames,
                 const float* coordinate, const OrderCosts& costs) {
  HWY_DYNAMIC_DISPATCH(CostsOfOrders)(stage, to_8_bits, frames, coordinate, costs);
}

void find_disagreeing(const CueStage& cue, const CoordinateRows& rows,
                      std::vector<PixelPlace>& found) {
  HWY_DYNAMIC_DISPATCH(FindDisagreeing)(cue, rows, found);
}

}  // namespace slipstream
#endif
