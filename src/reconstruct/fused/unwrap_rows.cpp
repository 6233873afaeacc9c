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

/// The darkest and the brightest level of some frames.
struct LevelRange {
  Ints darkest, brightest;
};

/// The number that each pixel's bits show, the first frame's bit the highest.
struct ShownNumber {
  Ints bits;
  Ints doubtful;        ///< of a code alone: bits within the tolerance of their threshold
  Ints doubtful_count;  ///< how many these are
};

/// The first and the last stripe that the doubtful bits allow.
struct StripeSpan {
  Ints first, last;
  hn::Mask<IntTag> readable;  ///< else with too many doubtful bits, and read as it stands
};

/// -1 where the test is true, else 0.
template <class Test>
HWY_INLINE Ints minus_one_where(Test test) {
  const IntTag di;
  return hn::VecFromMask(di, hn::RebindMask(di, test));
}

/// Reads the code of one row, see code_row. `alone`: CodeStage::alone, else also a part of the
/// phase. The members used for each bit are copies, so that no store can alias them.
template <bool alone, class Pixel>
class CodeVectors {
 public:
  HWY_INLINE CodeVectors(const CodeStage& stage, float grey_level, const Pixel* const* frames,
                         const float* reference, float* contrast)
      : stage_(stage),
        bits_(stage.frames),
        inverses_(stage.inverses),
        frames_(frames),
        reference_(reference),
        contrast_(contrast),
        tolerance_(hn::Set(FloatTag(), grey_level * stage.tolerance)),
        least_contrast_(hn::Set(FloatTag(), grey_level * stage.least_contrast)) {}

  /// The coordinates of the vector from pixel `i` on.
  HWY_INLINE Unwrapped read(std::size_t i, Ints flags) const {
    LevelRange levels = levels_of_bits(i);
    const ShownNumber number = shown_number(i, threshold(levels, i));
    const StripeSpan stripes = allowed_stripes(number);
    const Floats y = middle_of(stripes);

    if constexpr (!alone) {
      return Unwrapped{y, hn::Zero(FloatTag()), flags};
    } else {
      // The contrast counts all frames.
      widen(levels, stage_.rest, i);
      const Floats contrast = contrast_of(levels);
      if (contrast_ != nullptr) hn::StoreU(contrast, FloatTag(), contrast_ + i);

      return Unwrapped{y, doubt_of(stripes), hn::Or(flags, dark_flags(contrast))};
    }
  }

 private:
  static constexpr int most_doubtful = 4;  // see read_code

  HWY_INLINE Ints level(int frame, std::size_t i) const { return load_pixels(frames_[frame] + i); }

  /// Widens the range to the levels of these frames.
  HWY_INLINE void widen(LevelRange& levels, std::span<const int> frames, std::size_t i) const {
    for (const int frame : frames) {
      levels.darkest = hn::Min(levels.darkest, level(frame, i));
      levels.brightest = hn::Max(levels.brightest, level(frame, i));
    }
  }

  /// Levels of all bits where their range counts, else of the first one.
  HWY_INLINE LevelRange levels_of_bits(std::size_t i) const {
    const Ints first = level(bits_.front(), i);
    LevelRange levels{first, first};
    if (alone || (reference_ == nullptr && inverses_.empty())) widen(levels, bits_, i);

    return levels;
  }

  /// The level above which a bit is bright: the reference, or half way between the darkest and the
  /// brightest bit.
  HWY_INLINE Floats threshold(const LevelRange& levels, std::size_t i) const {
    const FloatTag d;
    if (reference_ != nullptr) return hn::LoadU(d, reference_ + i);

    const Ints twice = hn::Add(levels.darkest, levels.brightest);
    return hn::Mul(hn::Set(d, 0.5F), hn::ConvertTo(d, twice));
  }

  /// Reads the bits, the highest first: each is compared with its inverse, or with the limit.
  HWY_INLINE ShownNumber shown_number(std::size_t i, Floats limit) const {
    const FloatTag d;
    const IntTag di;

    // A whole level is above a number if it is above the number rounded down.
    const Ints whole_limit = hn::ConvertTo(di, hn::Floor(limit));

    ShownNumber number{hn::Zero(di), hn::Zero(di), hn::Zero(di)};
    for (std::size_t bit = 0; bit < bits_.size(); ++bit) {
      const Ints here = level(bits_[bit], i);
      const Ints dark = inverses_.empty() ? whole_limit : level(inverses_[bit], i);
      number.bits = with_bit(number.bits, minus_one_where(hn::Gt(here, dark)));

      // A bit within the tolerance of its threshold is doubtful.
      if constexpr (alone) {
        const Floats above = inverses_.empty()
                                 ? hn::Sub(hn::ConvertTo(d, here), limit)
                                 : hn::Mul(hn::Set(d, 0.5F), hn::ConvertTo(d, hn::Sub(here, dark)));
        const Ints unsure = minus_one_where(hn::Lt(hn::Abs(above), tolerance_));
        number.doubtful = with_bit(number.doubtful, unsure);
        number.doubtful_count = hn::Sub(number.doubtful_count, unsure);
      }
    }

    return number;
  }

  /// Appends a bit to the number. `mask`: -1 for a bit of 1.
  static HWY_INLINE Ints with_bit(Ints number, Ints mask) {
    return hn::Sub(hn::Add(number, number), mask);
  }

  HWY_INLINE StripeSpan allowed_stripes(const ShownNumber& number) const {
    const IntTag di;
    const auto readable = hn::Lt(number.doubtful_count, hn::Set(di, most_doubtful + 1));
    const Ints doubtful = hn::IfThenElseZero(readable, number.doubtful);

    const Ints as_shown = stripes(stage_, number.bits);
    StripeSpan span{as_shown, as_shown, readable};

    // Pixels with fewer doubtful bits go through theirs again until all end at once.
    // Counting down as (wrong - 1) & doubtful visits every subset of the doubtful bits.
    for (Ints wrong = doubtful; alone && !hn::AllTrue(di, hn::Eq(wrong, hn::Zero(di)));
         wrong = hn::And(hn::Sub(wrong, hn::Set(di, 1)), doubtful)) {
      const Ints stripe = stripes(stage_, hn::Xor(number.bits, wrong));
      span.first = hn::Min(span.first, stripe);
      span.last = hn::Max(span.last, stripe);
    }

    return span;
  }

  /// The coordinate of the middle of these stripes; of a code alone, of their pixels.
  HWY_INLINE Floats middle_of(const StripeSpan& span) const {
    const FloatTag d;
    const IntTag di;
    const Ints one = hn::Set(di, 1);

    if constexpr (alone) {
      const int* const first_pixels = stage_.first_pixels.data();
      const Ints begin = hn::GatherIndex(di, first_pixels, span.first);
      const Ints end = hn::GatherIndex(di, first_pixels, hn::Add(span.last, one));

      // A quotient of whole numbers is rounded once.
      const Ints twice_the_middle = hn::Sub(hn::Add(begin, end), one);
      return hn::Div(hn::ConvertTo(d, twice_the_middle), hn::Set(d, 2 * stage_.pixels));
    }

    const Ints twice_the_middle = hn::Add(hn::Add(span.first, span.last), one);
    return hn::Mul(hn::ConvertTo(d, twice_the_middle), hn::Set(d, stage_.stripe / 2));
  }

  /// Half the range of the levels.
  HWY_INLINE Floats contrast_of(const LevelRange& levels) const {
    const FloatTag d;
    const Ints range = hn::Sub(levels.brightest, levels.darkest);
    return hn::Mul(hn::Set(d, 0.5F), hn::ConvertTo(d, range));
  }

  /// The flag of pixels with too little contrast.
  HWY_INLINE Ints dark_flags(Floats contrast) const {
    const Ints is_dark = minus_one_where(hn::Lt(contrast, least_contrast_));
    return hn::And(is_dark, hn::Set(IntTag(), PixelFlag::dark));
  }

  /// An eighth per stripe of spread, at most a half. An unreadable code could be any stripe.
  HWY_INLINE Floats doubt_of(const StripeSpan& span) const {
    const FloatTag d;
    const Floats apart = hn::ConvertTo(d, hn::Sub(span.last, span.first));
    const Floats spread =
        hn::IfThenElse(hn::RebindMask(d, span.readable), apart, hn::Set(d, 1 / stage_.stripe));

    return hn::Min(hn::Set(d, 0.5F), hn::Mul(spread, hn::Set(d, 0.125F)));
  }

  const CodeStage& stage_;
  std::span<const int> bits_, inverses_;
  const Pixel* const* frames_;
  const float* reference_;
  float* contrast_;
  Floats tolerance_, least_contrast_;
};

template <bool alone, class Pixel>
HWY_NOINLINE void read_row(const CodeStage& stage, float grey_level, const Pixel* const* frames,
                           const float* reference, float* contrast, const UnwrappedRow& row) {
  const CodeVectors<alone, Pixel> vectors(stage, grey_level, frames, reference, contrast);
  const auto read = [&](std::size_t i, Ints flags)
                        SLIPSTREAM_STEP { return vectors.read(i, flags); };

  if (alone) return unwrap_vectors(row, stage.largest_doubt, read);

  // The start of a chain: the later links judge the doubt.
  for_each_vector(row.width, [&](std::size_t i) SLIPSTREAM_STEP {
    hn::StoreU(read(i, hn::Zero(IntTag())).y, FloatTag(), row.coordinate + i);
  });
}

void CodeRow(const CodeStage& stage, float grey_level, const FrameRows& frames,
             const float* reference, float* contrast, const UnwrappedRow& row) {
  const auto read = [&](auto of) {
    if (stage.alone) {
      read_row<true>(stage, grey_level, of, reference, contrast, row);
    } else {
      read_row<false>(stage, grey_level, of, reference, contrast, row);
    }
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
