#include "slipstream/reconstruct/fused/code_rows.h"

#include <cstddef>

#include "slipstream/base/disabled_targets-inl.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slipstream/reconstruct/fused/code_rows.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "slipstream/base/vectors-inl.h"
#include "slipstream/reconstruct/fused/frame_sums-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// stripe_of.
HWY_INLINE Ints stripes(const CodeStage& stage, Ints shown) {
  const IntTag di;
  if (stage.base != 0) {
    const auto inverted = hn::Ne(hn::And(shown, hn::Set(di, stage.base)), hn::Zero(di));
    shown = hn::Xor(shown, hn::IfThenElseZero(inverted, hn::Set(di, stage.others)));
  }
  if (!stage.gray) return shown;
  shown = hn::Xor(shown, hn::ShiftRight<1>(shown));
  shown = hn::Xor(shown, hn::ShiftRight<2>(shown));
  shown = hn::Xor(shown, hn::ShiftRight<4>(shown));
  if (stage.frames.size() <= 8) return shown;
  shown = hn::Xor(shown, hn::ShiftRight<8>(shown));
  return hn::Xor(shown, hn::ShiftRight<16>(shown));
}

template <class Pixel>
HWY_INLINE void read_row(const CodeStage& stage, int width, const Pixel* const* frames,
                         const float* reference, float* coordinate) {
  const FloatTag d;
  const IntTag di;
  const std::size_t bits = stage.frames.size();
  const int* const frame = stage.frames.data();
  const int* const inverse = stage.inverses.empty() ? nullptr : stage.inverses.data();
  const Floats width_of_one = hn::Set(d, stage.stripe), half = hn::Set(d, stage.stripe / 2);
  for_each_vector(width, [&](std::size_t i) SLIPSTREAM_STEP {
    // A whole level is above a number where it is above what is left of it without its part.
    Ints limit = hn::Zero(di);
    if (inverse == nullptr) limit = hn::ConvertTo(di, hn::LoadU(d, reference + i));
    Ints shown = hn::Zero(di);
    for (std::size_t bit = 0; bit < bits; ++bit) {
      if (inverse != nullptr) limit = load_pixels(frames[inverse[bit]] + i);
      const auto bright = hn::Gt(load_pixels(frames[frame[bit]] + i), limit);
      shown = hn::Sub(hn::Add(shown, shown), hn::VecFromMask(di, bright));  // a mask is -1
    }
    const Floats stripe = hn::ConvertTo(d, stripes(stage, shown));
    hn::StoreU(hn::MulAdd(stripe, width_of_one, half), d, coordinate + i);
  });
}

void CodeRow8(const CodeStage& stage, int width, const std::uint8_t* const* frames,
              const float* reference, float* coordinate) {
  read_row(stage, width, frames, reference, coordinate);
}

void CodeRow16(const CodeStage& stage, int width, const std::uint16_t* const* frames,
               const float* reference, float* coordinate) {
  read_row(stage, width, frames, reference, coordinate);
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(CodeRow8);
HWY_EXPORT(CodeRow16);

void code_row(const CodeStage& stage, int width, const std::uint8_t* const* frames,
              const float* reference, float* coordinate) {
  HWY_DYNAMIC_DISPATCH(CodeRow8)(stage, width, frames, reference, coordinate);
}

void code_row(const CodeStage& stage, int width, const std::uint16_t* const* frames,
              const float* reference, float* coordinate) {
  HWY_DYNAMIC_DISPATCH(CodeRow16)(stage, width, frames, reference, coordinate);
}

}  // namespace slipstream
#endif
