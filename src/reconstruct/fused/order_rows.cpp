// Coordinates of a row from the fringe order that fits all frames of a pixel best.
#include "reconstruct/fused/order_rows.h"

#include <array>
#include <limits>
#include <variant>

#include "reconstruct/fused/unwrap_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "reconstruct/fused/order_rows.cpp"
#include <hwy/foreach_target.h>

#include "base/vectors-inl.h"
#include "reconstruct/fused/sinusoid_sums-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// Cosine and sine of an angle in turns, to 2e-7.
struct Direction {
  Floats cosine, sine;
};

HWY_INLINE Direction direction_of(Floats turns) {
  const FloatTag d;
  const IntTag di;
  constexpr std::array cosines{56.2387009F, -85.2398682F, 64.9345703F, -19.739172F, 0.99999994F};
  constexpr std::array sines{39.7598267F, -76.5811691F, 81.602478F, -41.3416824F, 6.28318548F};

  // Half turns change both signs; the rest is at most a quarter.
  const Floats halves = hn::Round(hn::Add(turns, turns));
  const Floats sign = hn::BitCast(d, hn::ShiftLeft<31>(hn::ConvertTo(di, halves)));
  const Floats t = hn::NegMulAdd(halves, hn::Set(d, 0.5F), turns), t2 = hn::Mul(t, t);

  // Polynomials in t^2, highest power first.
  Floats c = hn::Set(d, cosines[0]), s = hn::Set(d, sines[0]);
  for (std::size_t i = 1; i < cosines.size(); ++i) {
    c = hn::MulAdd(c, t2, hn::Set(d, cosines[i]));
    s = hn::MulAdd(s, t2, hn::Set(d, sines[i]));
  }

  return {hn::Xor(c, sign), hn::Xor(hn::Mul(s, t), sign)};
}

/// The order of least cost, and the least and the next cost.
struct Likeliest {
  Floats order, least, next;
};

/// `cost(k, order)`: of order k - 1.
template <class Cost>
HWY_INLINE Likeliest likeliest_order(const OrderStage& stage, Floats turn, const Cost& cost) {
  const FloatTag d;
  const Floats begin = hn::Set(d, stage.begin), end = hn::Set(d, stage.end);
  const Floats none = hn::Set(d, std::numeric_limits<float>::infinity());

  Likeliest found{hn::Set(d, -1.0F), none, none};
  for (int k = 0; k < stage.orders; ++k) {
    const Floats order = hn::Set(d, static_cast<float>(k - 1)), at = hn::Add(turn, order);

    // Orders outside the field are never chosen.
    const auto in_field = hn::And(hn::Ge(at, begin), hn::Lt(at, end));
    const Floats tried = hn::IfThenElse(in_field, cost(static_cast<std::size_t>(k), order), none);

    // Keep the least cost and the next.
    found.order = hn::IfThenElse(hn::Lt(tried, found.least), order, found.order);
    found.next = hn::Min(found.next, hn::Max(found.least, tried));
    found.least = hn::Min(found.least, tried);
  }

  return found;
}

void LikelihoodRow(const OrderStage& stage, const Image<float>& turns,
                   const Image<float>& modulations, const UnwrappedRow& row) {
  const FloatTag d;
  const std::size_t bands = stage.waves.size();

  const auto ratio = [&](std::size_t n)
                         SLIPSTREAM_STEP { return hn::Set(d, stage.waves[n].ratio); };

  unwrap_vectors(row, stage.largest_doubt, [&](std::size_t i, Ints flags) SLIPSTREAM_STEP {
    const auto load = [&](const Image<float>& rows, std::size_t n) SLIPSTREAM_STEP {
      return hn::LoadU(d, rows.row(static_cast<int>(n)) + i);
    };

    // Weight of each band: the inverse variance of its phase, which grows with B^2. `apart` is the
    // phase predicted at order 0 less the band's own.
    const Floats turn = load(turns, 0);
    Several<OrderStage::most_waves> apart, weight;
    Floats length = hn::Zero(d);
    for (std::size_t n = 0; n < bands; ++n) {
      const Floats B = load(modulations, n);
      weight[n] = hn::Mul(hn::Mul(B, B), hn::Set(d, stage.waves[n].weight));
      length = hn::MulAdd(weight[n], hn::Mul(ratio(n), ratio(n)), length);
      apart[n] = hn::MulSub(turn, ratio(n), load(turns, n));
    }

    // Residual of a band's phase at an order, in periods: see fringe_order_residual.
    const auto residual = [&](std::size_t n, Floats order) SLIPSTREAM_STEP {
      const Floats periods = hn::MulAdd(order, ratio(n), apart[n]);
      return hn::Sub(periods, hn::Round(periods));
    };

    const Floats inverse = hn::Div(hn::Set(d, 1.0F), hn::Max(length, hn::Set(d, 1e-30F)));

    // Cost of an order: the weighted squares of its residuals, less the part that goes away at the
    // coordinate nearby that fits all bands best.
    const auto cost = [&](std::size_t, Floats order) SLIPSTREAM_STEP {
      Floats square = hn::Zero(d), along = square;
      for (std::size_t n = 0; n < bands; ++n) {
        const Floats r = residual(n, order), weighed = hn::Mul(weight[n], r);
        square = hn::MulAdd(weighed, r, square);
        along = hn::MulAdd(weighed, ratio(n), along);
      }
      return hn::NegMulAdd(hn::Mul(along, inverse), along, square);
    };

    // The doubt is the largest residual of any band.
    const Floats order = likeliest_order(stage, turn, cost).order;
    Floats doubt = hn::Zero(d);
    for (std::size_t n = 0; n < bands; ++n) doubt = hn::Max(doubt, hn::Abs(residual(n, order)));

    return Unwrapped{hn::Mul(hn::Add(turn, order), hn::Set(d, stage.period)), doubt, flags};
  });
}

/// A vector of pixels in the frames of an OrderStage, each A + B cos(a).
class FramesFit {
 public:
  template <class Pixel>
  HWY_INLINE FramesFit(const OrderStage& stage, const Pixel* const* frames, std::size_t i)
      : stage_(stage), count_(stage.waves.size()), share_(1 / static_cast<float>(count_)) {
    const auto level = [&](std::size_t n) SLIPSTREAM_STEP {
      return load_pixels(frames[stage.waves[n].frame] + i);
    };

    // The mean over all frames first, then each frame less this mean.
    Ints sum = hn::Zero(IntTag());
    greatest = sum;
    for (std::size_t n = 0; n < count_; ++n) {
      sum = hn::Add(sum, level(n));
      greatest = hn::Max(greatest, level(n));
    }

    square_ = hn::Zero(FloatTag());
    for (std::size_t n = 0; n < count_; ++n) {
      I_[n] = hn::NegMulAdd(hn::ConvertTo(FloatTag(), sum), set(share_),
                            hn::ConvertTo(FloatTag(), level(n)));
      square_ = hn::MulAdd(I_[n], I_[n], square_);
    }
  }

  /// `doubt`: half the root of the least misfit over the next order's.
  [[nodiscard]] HWY_INLINE Floats order(Floats turn, Floats& doubt) const {
    const FloatTag d;

    // 1. Direction of each wave at order 0. An order only turns it, by its stored beginning.
    Several<OrderStage::most_waves> cosine, sine;  // of the phase
    for (std::size_t n = 0; n < count_; ++n) {
      const Direction phase = direction_of(hn::Mul(turn, set(stage_.waves[n].ratio)));
      cosine[n] = phase.cosine;
      sine[n] = phase.sine;
    }

    struct Sums {
      Floats shown, square, covariance;
    };

    const auto add = [&](Sums& sums, std::size_t k, std::size_t n) SLIPSTREAM_STEP {
      const auto& [c, s] = stage_.beginnings[k * count_ + n];
      const Floats shown = hn::NegMulAdd(set(s), sine[n], hn::Mul(set(c), cosine[n]));
      sums.shown = hn::Add(sums.shown, shown);
      sums.square = hn::MulAdd(shown, shown, sums.square);
      sums.covariance = hn::MulAdd(shown, I_[n], sums.covariance);
    };

    // The band's own steps are the same in every order.
    Sums of_steps{hn::Zero(d), hn::Zero(d), hn::Zero(d)};
    for (std::size_t n = 0; n < stage_.steps; ++n) add(of_steps, 0, n);

    // 2. Try all orders. Cost: minus the part of the frames' variation that an order explains; a
    // falling line explains none.
    const auto cost = [&](std::size_t k, Floats) SLIPSTREAM_STEP {
      Sums sums = of_steps;
      for (std::size_t n = stage_.steps; n < count_; ++n) add(sums, k, n);
      const Floats covariance = hn::Max(sums.covariance, hn::Zero(d));
      return hn::Neg(hn::Div(hn::Mul(covariance, covariance), less_mean(sums.square, sums.shown)));
    };

    // 3. The doubt compares the misfits of the best order and the next.
    const Likeliest found = likeliest_order(stage_, turn, cost);
    const Floats least = hn::Max(hn::Add(square_, found.least), hn::Zero(d));
    const Floats next = hn::Add(square_, found.next);
    doubt = hn::IfThenElse(hn::Gt(next, hn::Zero(d)),
                           hn::Mul(set(0.5F), hn::Sqrt(hn::Div(least, next))), set(0.5F));

    return found.order;
  }

  /// Gauss-Newton refinement of the turn: BandUnwrapper::refined.
  [[nodiscard]] HWY_INLINE Floats refined(Floats turn, Floats order) const {
    constexpr int steps = 4;
    const FloatTag d;
    const Floats most = set(0.25F);

    Floats moved = hn::Zero(d);
    for (int step = 0; step < steps; ++step) {
      // Sums of c = cos(a), of s, its change with the turn over 2 pi, and of their products.
      Floats c = hn::Zero(d), s = c, cc = c, cs = c, ss = c, cI = c, sI = c;
      for (std::size_t n = 0; n < count_; ++n) {
        // Whole turns of the order are taken off first.
        const Floats ratio = set(stage_.waves[n].ratio), turns = hn::Mul(order, ratio);
        const Floats begin = hn::MulSub(order, ratio, hn::Round(turns));

        const Direction a = direction_of(
            hn::MulAdd(hn::Add(turn, moved), ratio, hn::Sub(begin, set(stage_.waves[n].shift))));
        const Floats slope = hn::Neg(hn::Mul(a.sine, ratio));

        c = hn::Add(c, a.cosine);
        s = hn::Add(s, slope);
        cc = hn::MulAdd(a.cosine, a.cosine, cc);
        cs = hn::MulAdd(a.cosine, slope, cs);
        ss = hn::MulAdd(slope, slope, ss);
        cI = hn::MulAdd(a.cosine, I_[n], cI);
        sI = hn::MulAdd(slope, I_[n], sI);
      }

      // A and B are eliminated: B by the fit to c, and the step from the part of s that c does not
      // explain. The turn moves a quarter at most, and not at all if the step is not finite.
      cc = less_mean(cc, c);
      cs = hn::NegMulAdd(hn::Mul(c, set(share_)), s, cs);
      const Floats B = hn::Div(cI, cc);
      const Floats across = hn::NegMulAdd(hn::Div(cs, cc), cs, less_mean(ss, s));
      const Floats change =
          hn::Div(hn::NegMulAdd(B, cs, sI), hn::Mul(hn::Mul(set(6.2831853F), B), across));
      const Floats next = hn::Min(hn::Max(hn::Add(moved, change), hn::Neg(most)), most);
      moved = hn::IfThenElseZero(hn::IsFinite(change), next);
    }

    return hn::Add(turn, moved);
  }

  Ints greatest;

 private:
  static HWY_INLINE Floats set(float value) { return hn::Set(FloatTag(), value); }

  /// The sum of squares of numbers less their mean.
  [[nodiscard]] HWY_INLINE Floats less_mean(Floats square, Floats sum) const {
    return hn::NegMulAdd(hn::Mul(sum, set(share_)), sum, square);
  }

  const OrderStage& stage_;
  std::size_t count_;
  float share_;
  Floats square_;
  Several<OrderStage::most_waves> I_;  ///< less the mean of all frames
};

template <class Pixel>
HWY_NOINLINE void fit_pixels(const OrderStage& stage, const SinusoidLimits& limits,
                             const Pixel* const* frames, const float* turns,
                             const UnwrappedRow& row) {
  const FloatTag d;
  unwrap_vectors(row, stage.largest_doubt, [&](std::size_t i, Ints flags) SLIPSTREAM_STEP {
    const FramesFit fit(stage, frames, i);
    const Floats turn = hn::LoadU(d, turns + i);

    Floats doubt;
    const Floats order = fit.order(turn, doubt);
    const Floats y = hn::Mul(hn::Add(fit.refined(turn, order), order), hn::Set(d, stage.period));
    return Unwrapped{y, doubt, hn::Or(flags, saturation_flag(limits, fit.greatest))};
  });
}

void FitRow(const OrderStage& stage, const SinusoidLimits& limits, const FrameRows& frames,
            const float* turn, const UnwrappedRow& row) {
  std::visit([&](auto of) { fit_pixels(stage, limits, of, turn, row); }, frames);
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(LikelihoodRow);
HWY_EXPORT(FitRow);

void likelihood_row(const OrderStage& stage, const Image<float>& turns,
                    const Image<float>& modulations, const UnwrappedRow& row) {
  HWY_DYNAMIC_DISPATCH(LikelihoodRow)(stage, turns, modulations, row);
}

void fit_row(const OrderStage& stage, const SinusoidLimits& limits, const FrameRows& frames,
             const float* turn, const UnwrappedRow& row) {
  HWY_DYNAMIC_DISPATCH(FitRow)(stage, limits, frames, turn, row);
}

}  // namespace slipstream
#endif
