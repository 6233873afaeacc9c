// Coordinates of a row from phases: by a code, a coarser coordinate, or the phase alone.
#include "slipstream/reconstruct/fused/rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slipstream/reconstruct/fused/unwrap_rows.cpp"
#include <hwy/foreach_target.h>

#include "slipstream/base/vectors-inl.h"
#include "slipstream/reconstruct/fused/sinusoid_sums-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// See stripe_of.
HWY_INLINE Ints stripes(const CodeStage& stage, Ints shown) {
  const IntTag di;
  if (stage.base != 0) {
    const auto inverted = hn::Ne(hn::And(shown, hn::Set(di, stage.base)), hn::Zero(di));
    shown = hn::Xor(shown, hn::IfThenElseZero(inverted, hn::Set(di, stage.others)));
  }
  if (stage.gray == 0) return shown;
  shown = hn::Xor(shown, hn::ShiftRight<1>(shown));
  shown = hn::Xor(shown, hn::ShiftRight<2>(shown));
  shown = hn::Xor(shown, hn::ShiftRight<4>(shown));
  if (stage.frames.size() <= 8) return shown;
  shown = hn::Xor(shown, hn::ShiftRight<8>(shown));
  return hn::Xor(shown, hn::ShiftRight<16>(shown));
}

template <class Pixel>
HWY_NOINLINE void read_row(const CodeStage& stage, int width, const Pixel* const* frames,
                           const float* reference, float* coordinate) {
  const FloatTag d;
  const IntTag di;
  const std::size_t bits = stage.frames.size();
  const int* const frame = stage.frames.data();
  const int* const inverse = stage.inverses.empty() ? nullptr : stage.inverses.data();
  const Floats width_of_one = hn::Set(d, stage.stripe), half = hn::Set(d, stage.stripe / 2);
  for_each_vector(width, [&](std::size_t i) SLIPSTREAM_STEP {
    // A whole level is above a number if it is above the number rounded down.
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

void CodeRow(const CodeStage& stage, int width, const FrameRows& frames, const float* reference,
             float* coordinate) {
  if (frames.of_8_bits != nullptr) {
    return read_row(stage, width, frames.of_8_bits, reference, coordinate);
  }
  read_row(stage, width, frames.of_16_bits, reference, coordinate);
}

void PlaceRow(const CoordinateStage& stage, int width, const float* turn, float* coordinate) {
  const FloatTag d;
  const FieldPlacer in_field(stage);
  for_each_vector(width, [&](std::size_t i) SLIPSTREAM_STEP {
    hn::StoreU(in_field(hn::LoadU(d, turn + i)), d, coordinate + i);
  });
}

void PlaceNear(float periods, int width, const float* turn, const float* near, float* coordinate) {
  const FloatTag d;
  const Floats f = hn::Set(d, periods), period = hn::Set(d, 1 / periods);
  for_each_vector(width, [&](std::size_t i) SLIPSTREAM_STEP {
    const Floats part = hn::LoadU(d, turn + i);
    const Floats k = hn::Round(hn::MulSub(hn::LoadU(d, near + i), f, part));
    hn::StoreU(hn::Mul(hn::Add(part, k), period), d, coordinate + i);
  });
}

void UnwrapRow(const UnwrapStage& stage, const float* high_turn, const float* low_turn,
               const UnwrappedRow& row) {
  const FloatTag d;
  const FieldPlacer in_field(stage.coordinate);
  const Floats ratio = hn::Set(d, stage.ratio);
  const Floats open = hn::Set(d, stage.open), doubt_scale = hn::Set(d, stage.doubt_scale);
  unwrap_vectors(row, stage.largest_doubt, [&](std::size_t i, Ints flags) SLIPSTREAM_STEP {
    const Floats high = hn::LoadU(d, high_turn + i);
    const Floats periods = hn::MulSub(hn::LoadU(d, low_turn + i), ratio, high);
    const Floats k = hn::Round(periods);  // (1.17)
    const Floats beyond = hn::Sub(hn::Abs(hn::Sub(periods, k)), open);
    return Unwrapped{in_field(hn::Add(high, k)), hn::Mul(hn::Max(beyond, hn::Zero(d)), doubt_scale),
                     flags};
  });
}

void PhaseRow(int width, const float* turn, float* phase) {
  const FloatTag d;
  // The largest float below 2 pi; a whole turn becomes 0.
  const Floats two_pi = hn::Set(d, 6.2831850F);
  for_each_vector(width, [&](std::size_t i) SLIPSTREAM_STEP {
    const Floats t = hn::LoadU(d, turn + i);
    Floats part = hn::Sub(t, hn::Floor(t));
    part = hn::IfThenElseZero(hn::Lt(part, hn::Set(d, 1.0F)), part);
    hn::StoreU(hn::Min(hn::Mul(part, hn::Set(d, 6.2831853F)), two_pi), d, phase + i);
  });
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(CodeRow);
HWY_EXPORT(PlaceRow);
HWY_EXPORT(PlaceNear);
HWY_EXPORT(UnwrapRow);
HWY_EXPORT(PhaseRow);

void code_row(const CodeStage& stage, int width, const FrameRows& frames, const float* reference,
              float* coordinate) {
  HWY_DYNAMIC_DISPATCH(CodeRow)(stage, width, frames, reference, coordinate);
}

void place_row(const CoordinateStage& stage, int width, const float* turn, float* coordinate) {
  HWY_DYNAMIC_DISPATCH(PlaceRow)(stage, width, turn, coordinate);
}

void place_near(float periods, int width, const float* turn, const float* near, float* coordinate) {
  HWY_DYNAMIC_DISPATCH(PlaceNear)(periods, width, turn, near, coordinate);
}

void unwrap_row(const UnwrapStage& stage, const float* high_turn, const float* low_turn,
                const UnwrappedRow& row) {
  HWY_DYNAMIC_DISPATCH(UnwrapRow)(stage, high_turn, low_turn, row);
}

void phase_row(int width, const float* turn, float* phase) {
  HWY_DYNAMIC_DISPATCH(PhaseRow)(width, turn, phase);
}

}  // namespace slipstream
#endif
