// Coordinates of a row from phases: by a code, a coarser coordinate, or the phase alone.
#include "reconstruct/fused/unwrap_rows.h"

#include <span>
#include <variant>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "reconstruct/fused/unwrap_rows.cpp"
#include <hwy/foreach_target.h>

#include "base/vectors-inl.h"
#include "reconstruct/fused/sinusoid_sums-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// See stripe_of.
HWY_INLINE Ints stripes(const CodeStage& stage, Ints shown) {
  const IntTag di;

  // With a base bit, the others are inverted wherever it is bright.
  if (stage.base != 0) {
    const auto inverted = hn::Ne(hn::And(shown, hn::Set(di, stage.base)), hn::Zero(di));
    shown = hn::Xor(shown, hn::IfThenElseZero(inverted, hn::Set(di, stage.others)));
  }

  // From Gray code to binary: each bit is XORed with all higher ones, in doubling strides.
  if (stage.gray == 0) return shown;
  shown = hn::Xor(shown, hn::ShiftRight<1>(shown));
  shown = hn::Xor(shown, hn::ShiftRight<2>(shown));
  shown = hn::Xor(shown, hn::ShiftRight<4>(shown));

  // Eight bits are done after strides of 1, 2 and 4.
  if (stage.frames.size() <= 8) return shown;
  shown = hn::Xor(shown, hn::ShiftRight<8>(shown));
  return hn::Xor(shown, hn::ShiftRight<16>(shown));
}

/// `alone`: CodeStage::alone, else also a part of the phase.
template <bool alone, class Pixel>
HWY_NOINLINE void read_row(const CodeStage& stage, float grey_level, const Pixel* const* frames,
                           const float* reference, float* contrast, const UnwrappedRow& row) {
  constexpr int most_doubtful = 4;  // see read_code

  // Local copies stay in registers: no store can alias them.
  const std::span<const int> bits = stage.frames, inverses = stage.inverses;

  const FloatTag d;
  const IntTag di;
  const Floats half = hn::Set(d, 0.5F), zero = hn::Zero(d);

  const Floats tolerance = hn::Set(d, grey_level * stage.tolerance);
  const Floats least = hn::Set(d, grey_level * stage.least_contrast);

  // -1 where the test is true, else 0.
  const auto mask = [&](auto test)
                        SLIPSTREAM_STEP { return hn::VecFromMask(di, hn::RebindMask(di, test)); };

  const auto read = [&](std::size_t i, Ints flags) SLIPSTREAM_STEP {
    const auto level = [&](int frame) SLIPSTREAM_STEP { return load_pixels(frames[frame] + i); };

    Ints darkest = level(bits.front()), brightest = darkest;
    const auto take = [&](std::span<const int> some) SLIPSTREAM_STEP {
      for (const int frame : some) {
        darkest = hn::Min(darkest, level(frame));
        brightest = hn::Max(brightest, level(frame));
      }
    };

    // 1. The level above which a bit is bright: the reference, or half way between the darkest and
    // the brightest bit.
    if (alone || (reference == nullptr && inverses.empty())) take(bits);
    Floats limit = hn::Mul(half, hn::ConvertTo(d, hn::Add(darkest, brightest)));
    if (reference != nullptr) limit = hn::LoadU(d, reference + i);

    // A whole level is above a number if it is above the number rounded down.
    const Ints whole_limit = hn::ConvertTo(di, hn::Floor(limit));

    // 2. Read the bits, the highest first. A bit within the tolerance of its threshold is doubtful.
    Ints shown = hn::Zero(di), doubtful = shown, count = shown;
    for (std::size_t bit = 0; bit < bits.size(); ++bit) {
      const Ints here = level(bits[bit]);
      const Ints dark = inverses.empty() ? whole_limit : level(inverses[bit]);
      shown = hn::Sub(hn::Add(shown, shown), mask(hn::Gt(here, dark)));  // a mask is -1

      if constexpr (alone) {
        const Floats above = inverses.empty()
                                 ? hn::Sub(hn::ConvertTo(d, here), limit)
                                 : hn::Mul(half, hn::ConvertTo(d, hn::Sub(here, dark)));
        const Ints unsure = mask(hn::Lt(hn::Abs(above), tolerance));
        doubtful = hn::Sub(hn::Add(doubtful, doubtful), unsure);
        count = hn::Sub(count, unsure);
      }
    }

    // 3. The first and last stripe that the doubtful bits allow. With too many of them the number
    // is unreadable, and the stripe is read as it stands.
    const auto readable = hn::Lt(count, hn::Set(di, most_doubtful + 1));
    doubtful = hn::IfThenElseZero(readable, doubtful);
    Ints first = stripes(stage, shown), last = first;

    // Pixels with fewer doubtful bits go through theirs again until all end at once.
    // Counting down as (wrong - 1) & doubtful visits every subset of the doubtful bits.
    for (Ints wrong = doubtful; alone && !hn::AllTrue(di, hn::Eq(wrong, hn::Zero(di)));
         wrong = hn::And(hn::Sub(wrong, hn::Set(di, 1)), doubtful)) {
      const Ints stripe = stripes(stage, hn::Xor(shown, wrong));
      first = hn::Min(first, stripe);
      last = hn::Max(last, stripe);
    }

    // 4. The middle of these stripes. `halves` is twice its stripe number, and `rest` corrects for
    // the stripe width's rounding to float.
    const Floats halves = hn::ConvertTo(d, hn::Add(hn::Add(first, last), hn::Set(di, 1)));
    const Floats rest =
        hn::NegMulAdd(halves, hn::Set(d, stage.narrower / 2), hn::Set(d, stage.shift));
    const Floats y = hn::MulAdd(halves, hn::Set(d, stage.stripe / 2), rest);

    if (!alone) return Unwrapped{y, zero, flags};

    // 5. Contrast over all frames, and the doubt: an eighth per stripe of spread, at most a half.
    // An unreadable code could be any stripe.
    take(stage.rest);
    const Floats range = hn::Mul(half, hn::ConvertTo(d, hn::Sub(brightest, darkest)));
    if (contrast != nullptr) hn::StoreU(range, d, contrast + i);

    const Floats spread =
        hn::IfThenElse(hn::RebindMask(d, readable), hn::ConvertTo(d, hn::Sub(last, first)),
                       hn::Set(d, 1 / stage.stripe));

    const Ints dark = hn::And(mask(hn::Lt(range, least)), hn::Set(di, PixelFlag::dark));
    return Unwrapped{y, hn::Min(half, hn::Mul(spread, hn::Set(d, 0.125F))), hn::Or(flags, dark)};
  };

  if (alone) return unwrap_vectors(row, stage.largest_doubt, read);

  // The start of a chain: the later links judge the doubt.
  for_each_vector(row.width, [&](std::size_t i) SLIPSTREAM_STEP {
    hn::StoreU(read(i, hn::Zero(di)).y, d, row.coordinate + i);
  });
}

void CodeRow(const CodeStage& stage, float grey_level, const FrameRows& frames,
             const float* reference, float* contrast, const UnwrappedRow& row) {
  const auto read = [&](auto of) {
    stage.alone ? read_row<true>(stage, grey_level, of, reference, contrast, row)
                : read_row<false>(stage, grey_level, of, reference, contrast, row);
  };

  std::visit(read, frames);
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

    // The fringe order that brings the coordinate nearest to `near`.
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

  // The fringe order is the whole number nearest to ratio * low - high. The distance from it,
  // beyond the part that a code leaves open, is the doubt.
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

  // Rounding can give a fractional part of exactly 1, which means 0.
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

void code_row(const CodeStage& stage, float grey_level, const FrameRows& frames,
              const float* reference, float* contrast, const UnwrappedRow& row) {
  HWY_DYNAMIC_DISPATCH(CodeRow)(stage, grey_level, frames, reference, contrast, row);
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
