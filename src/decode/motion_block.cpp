#include "decode/motion_block.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "decode/motion_block.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "base/vectors-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// Least squares for the change of a vector of pixels along the slope of their sinusoid.
struct Fit {
  Floats ratio;              ///< 2 sin(N v / 2)
  Floats square, explained;  ///< of all changes, and of the part explained
};

/// `speed`: by which the phase has moved since the window's middle.
HWY_INLINE Fit fit_of(const MotionWeights& weights, const float* levels, Floats C, Floats S,
                      Floats speed) {
  const FloatTag d;
  const auto all = [d](float value) SLIPSTREAM_STEP { return hn::Set(d, value); };

  // Sums over the pairs of frames that show one pattern.
  Floats along = hn::Zero(d), length = along, square = along;
  for (std::size_t n = 0; n < weights.from_middle.size(); ++n) {
    // Slope of the sinusoid at the time of the pair, C + i S turned by the speed.
    const Floats turned = hn::Mul(speed, all(weights.from_middle[n]));
    const Floats sine_part = hn::Mul(hn::NegMulAdd(turned, S, C), all(weights.sin_delta[n]));
    const Floats slope =
        hn::NegMulAdd(hn::MulAdd(turned, C, S), all(weights.cos_delta[n]), sine_part);

    const float* const level = levels + n * motion_block_pixels;
    const Floats change =
        hn::Sub(hn::LoadU(d, level + weights.cycle * motion_block_pixels), hn::LoadU(d, level));

    along = hn::MulAdd(change, slope, along);
    length = hn::MulAdd(slope, slope, length);
    square = hn::MulAdd(change, change, square);
  }

  // The least-squares ratio; 0 without modulation.
  const Floats ratio =
      hn::IfThenElseZero(hn::Gt(length, hn::Zero(d)), hn::Div(along, hn::Max(length, all(1e-30F))));
  return {ratio, square, hn::Mul(ratio, along)};
}

void MeasureMotion(const MotionWeights& weights, const MotionLevels& levels, MotionBlock& block) {
  const FloatTag d;
  const auto N = static_cast<float>(weights.cycle);
  const std::size_t K = weights.from_middle.size();
  // Each change is of two frames; the ratio takes one of K.
  const float per_change = K > 1 ? 1 / (2 * static_cast<float>(K - 1)) : 0;

  for (std::size_t i = 0; i < motion_block_pixels; i += hn::Lanes(d)) {
    const float* const level = levels.data() + i;
    // C + i S in the middle of the window.
    Floats C = hn::Zero(d), S = C;
    for (std::size_t n = 0; n < weights.cosine.size(); ++n) {
      const Floats I = hn::LoadU(d, level + n * motion_block_pixels);
      C = hn::MulAdd(hn::Set(d, weights.cosine[n]), I, C);
      S = hn::MulAdd(hn::Set(d, weights.sine[n]), I, S);
    }

    // The phase at which the slope is taken also moves: a second pass uses the speed of the first.
    const auto speed_by = [&](const Fit& fit) SLIPSTREAM_STEP {
      const Floats one = hn::Set(d, 1.0F), half = hn::Mul(fit.ratio, hn::Set(d, 0.5F));
      return hn::Mul(hn::Set(d, 2 / N), hn::Asin(d, hn::Clamp(half, hn::Neg(one), one)));
    };
    const Floats first = speed_by(fit_of(weights, level, C, S, hn::Zero(d)));
    const Fit fit = fit_of(weights, level, C, S, first);

    const Floats left = hn::Max(hn::Sub(fit.square, fit.explained), hn::Zero(d));

    // The speed, and the change it leaves.
    hn::StoreU(speed_by(fit), d, &block.speed[i]);
    hn::StoreU(hn::Sqrt(hn::Mul(left, hn::Set(d, per_change))), d, &block.unexplained[i]);
    hn::StoreU(hn::Sqrt(hn::MulAdd(C, C, hn::Mul(S, S))), d, &block.modulation[i]);
    hn::StoreU(fit.explained, d, &block.evidence[i]);
  }
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(MeasureMotion);

void measure_motion(const MotionWeights& weights, const MotionLevels& levels, MotionBlock& block) {
  HWY_DYNAMIC_DISPATCH(MeasureMotion)(weights, levels, block);
}

}  // namespace slipstream
#endif
