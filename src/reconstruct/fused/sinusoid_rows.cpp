// Turns, flags and levels of a row from frames.

#include "reconstruct/fused/sinusoid_rows.h"

#include <algorithm>
#include <array>
#include <span>
#include <type_traits>
#include <variant>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "reconstruct/fused/sinusoid_rows.cpp"
#include <hwy/foreach_target.h>

#include "base/vectors-inl.h"
#include "reconstruct/fused/sinusoid_sums-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

/// Folds the circle for N = 4 to the range of FoldedPhase: over the axes and their bisectors.
struct FoldOfFour {
  Floats U, V;

  HWY_INLINE Floats folded_U() const { return hn::Max(hn::Abs(U), hn::Abs(V)); }
  HWY_INLINE Floats folded_V() const { return hn::Min(hn::Abs(U), hn::Abs(V)); }

  HWY_INLINE Floats unfolded(Floats turn) const {
    return slipstream::HWY_NAMESPACE::unfolded(turn, V, U);
  }
};

/// Folds the circle for N = 3 and 6: over the axis V = 0; then a phase above 60 degrees becomes 120
/// degrees minus itself, mirrored at 0 if negative.
struct FoldOfThree {
  Floats U, V;

  HWY_INLINE Floats folded_U() const {
    const Floats v = hn::Abs(V);
    return hn::IfThenElse(hn::Gt(v, U), hn::MulSub(hn::Set(FloatTag(), 3.0F), v, U), U);
  }

  HWY_INLINE Floats folded_V() const {
    const Floats v = hn::Abs(V);
    return hn::IfThenElse(hn::Gt(v, U), hn::Abs(hn::Add(U, v)), v);
  }

  HWY_INLINE Floats unfolded(Floats turn) const {
    const FloatTag d;
    const Floats v = hn::Abs(V);
    const Floats back = hn::Sub(hn::Set(d, 1.0F / 3), hn::CopySign(turn, hn::Add(U, v)));

    // Undo the two foldings in reverse.
    const Floats half = hn::IfThenElse(hn::Gt(v, U), back, turn);
    return hn::IfThenElse(hn::Lt(V, hn::Zero(d)), hn::Sub(hn::Set(d, 1.0F), half), half);
  }
};

/// Evaluates FoldedPhase, in turns.
template <class Fold, std::size_t count>
HWY_INLINE Several<count> folded_turns(const FoldedPhase& folded, const Several<count>& V,
                                       const Several<count>& U) {
  const FloatTag d;

  // x of FoldedPhase, from the folded sums.
  Several<count> numerator, denominator;
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    const Fold fold{U[k], V[k]};
    const Floats u = hn::Max(fold.folded_U(), hn::Set(d, 1e-30F)), v = fold.folded_V();
    numerator[k] = hn::MulAdd(hn::Set(d, -2 - folded.b), v, u);
    denominator[k] = hn::MulAdd(hn::Set(d, folded.b), v, u);
  });

  const Several<count> x = quotients<count>(numerator, denominator);

  // The polynomial in x, highest power first.
  Several<count> turn;
  each<count>([&](std::size_t k) SLIPSTREAM_STEP { turn[k] = hn::Set(d, folded.coefficients[0]); });
  for (std::size_t i = 1; i < folded.coefficients.size(); ++i) {
    add_term<count>(turn, x, folded.coefficients[i]);
  }

  each<count>([&](std::size_t k) SLIPSTREAM_STEP { turn[k] = Fold{U[k], V[k]}.unfolded(turn[k]); });
  return turn;
}

/// Stores a vector's mean and modulation.
HWY_INLINE void store_levels(const SinusoidStage& stage, Floats sum, Floats square,
                             const SinusoidRow& row, std::size_t i) {
  const FloatTag d;

  // The first sinusoid gives the mean.
  if (!row.another) {
    fetch_ahead(row.mean + i, row.past_cache);
    store(hn::Mul(sum, hn::Set(d, row.limits.mean_scale)), row.mean + i, row.past_cache);
  }

  if (row.modulation == nullptr && row.own_modulation == nullptr) return;
  Floats modulation = hn::Mul(hn::Sqrt(square), hn::Set(d, stage.modulation_scale));
  if (row.own_modulation != nullptr) hn::StoreU(modulation, d, row.own_modulation + i);

  // Over several sinusoids the least modulation counts.
  if (row.modulation != nullptr) {
    if (row.another) modulation = hn::Min(modulation, hn::LoadU(d, row.modulation + i));
    hn::StoreU(modulation, d, row.modulation + i);
  }
}

/// Turns from sums. `N`: 3, 4 or 6 if the phase is folded, else 0.
template <int N, std::size_t count>
HWY_INLINE Several<count> turns(const SinusoidStage& stage, const Several<count>& U,
                                const Several<count>& V) {
  Several<count> turn;
  if constexpr (N != 0) {
    using Fold = std::conditional_t<N == 4, FoldOfFour, FoldOfThree>;
    turn = folded_turns<Fold, count>(stage.folded, V, U);
  } else {
    turn = corrected_turns<count>(stage, V, U);
  }

  return without_shifts<count>(stage, turn);
}

/// The position of the k-th vector from pixel `i` on.
HWY_INLINE std::size_t vector_at(std::size_t i, std::size_t k) {
  return i + k * hn::Lanes(FloatTag());
}

/// Whether all pixels of the vectors are flagged as dark.
template <std::size_t count>
HWY_INLINE bool all_dark(const SinusoidRow& row, std::size_t i) {
  const FloatTag d;
  const IntTag di;

  Ints common = hn::Set(di, PixelFlag::dark);
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    common = hn::And(common, hn::LoadU(di, row.flags + vector_at(i, k)));
  });

  return hn::AllTrue(d, is_dark(common));
}

/// Stores the flags of vectors from pixel `i` on. Frames are read again only if one is saturated.
template <std::size_t count, class Sums>
HWY_INLINE void store_flags(const Sums& sums, const Several<count, FloatMask>& dark, bool saturated,
                            const SinusoidRow& row, std::size_t i) {
  const IntTag di;

  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    const std::size_t pixel = vector_at(i, k);
    Ints flags = flag_where(dark[k], PixelFlag::dark);
    if (saturated) flags = hn::Or(flags, saturation_flag(row.limits, sums(pixel).greatest));
    if (row.another) flags = hn::Or(flags, hn::LoadU(di, row.flags + pixel));
    hn::StoreU(flags, di, row.flags + pixel);
  });
}

/// Stores the turns of vectors from pixel `i` on, NaN where flagged if so wanted.
template <std::size_t count>
HWY_INLINE void store_turns(Several<count> turn, const SinusoidRow& row, std::size_t i) {
  const FloatTag d;
  const IntTag di;

  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    const std::size_t pixel = vector_at(i, k);
    if (row.nan_if_flagged) {
      const Ints flags = hn::LoadU(di, row.flags + pixel);
      const auto good = hn::RebindMask(d, hn::Eq(flags, hn::Zero(di)));
      turn[k] = hn::IfThenElse(good, turn[k], nans());
    }
    hn::StoreU(turn[k], d, row.turn + pixel);
  });
}

/// Decodes vectors from pixel `i` on; `N` as in `turns`.
template <int N, std::size_t count, class Sums, class Saturated>
HWY_INLINE void decode_vectors(const SinusoidStage& stage, const Sums& sums,
                               const Saturated& saturation, const SinusoidRow& row, std::size_t i) {
  const FloatTag d;
  const IntTag di;

  // 1. Skip the vectors if all their pixels are known to be dark.
  if (row.only_lit && row.another && all_dark<count>(row, i)) return;

  // 2. Sums, levels, and which pixels are dark.
  Several<count> U, V;
  Several<count, FloatMask> dark;
  FloatMask any_dark = hn::FirstN(d, 0);
  const Floats least_square = hn::Set(d, row.limits.least_square);

  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    const FrameSums sum = sums(vector_at(i, k));
    U[k] = sum.U;
    V[k] = sum.V;

    const Floats square = modulation_square(stage, sum);
    dark[k] = hn::Lt(square, least_square);
    any_dark = hn::Or(any_dark, dark[k]);
    store_levels(stage, sum.sum, square, row, vector_at(i, k));
  });

  // 3. Mostly no pixel is dark or saturated. Otherwise set the flags first; the turns of dark
  // pixels may not be wanted.
  const bool saturated = saturation.template among<count>(i);
  const bool flagged = !hn::AllFalse(d, any_dark) || saturated;
  if (HWY_UNLIKELY(flagged)) {
    store_flags(sums, dark, saturated, row, i);

    if (row.only_lit && all_dark<count>(row, i)) {
      if (!row.nan_if_flagged) return;
      return each<count>([&](std::size_t k) SLIPSTREAM_STEP {
        hn::StoreU(nans(), d, row.turn + vector_at(i, k));
      });
    }
  }

  // 4. The turns, at one place: their code is long, and compiled for many kinds of sums.
  const Several<count> turn = turns<N, count>(stage, U, V);
  if (HWY_UNLIKELY(flagged)) return store_turns(turn, row, i);

  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    if (!row.another) hn::StoreU(hn::Zero(di), di, row.flags + vector_at(i, k));
    hn::StoreU(turn[k], d, row.turn + vector_at(i, k));
  });
}

template <int N, class Sums, class Saturated>
HWY_INLINE void decode_with(const SinusoidStage& stage, const Sums& sums,
                            const Saturated& saturation, const SinusoidRow& row) {
  for_each_group(static_cast<std::size_t>(row.width),
                 [&]<std::size_t count>(Together<count>, std::size_t i) SLIPSTREAM_STEP {
                   decode_vectors<N, count>(stage, sums, saturation, row, i);
                 });
}

template <int N, class Pixel>
HWY_INLINE void decode_closed_form(const SinusoidStage& stage, const Pixel* const* frames,
                                   const SinusoidRow& row) {
  std::array<const Pixel*, N> rows;
  std::copy_n(frames, N, rows.begin());
  const auto sums = [rows](std::size_t i)
                        SLIPSTREAM_STEP { return closed_form_sums<N>(rows.data(), i); };
  const Saturation saturation(rows.data(), N, row.limits.full_scale);

  if constexpr (N != 5) {
    if (!stage.folded.empty()) return decode_with<N>(stage, sums, saturation, row);
  }
  decode_with<0>(stage, sums, saturation, row);
}

template <class Pixel>
HWY_INLINE void decode_weighted(const SinusoidStage& stage, const Pixel* const* frames,
                                const SinusoidRow& row) {
  const Saturation saturation(frames, stage.cosines.size(), row.limits.full_scale);

  const std::span whole = stage.whole;
  const auto any = [&](std::size_t i) SLIPSTREAM_STEP { return general_sums(stage, frames, i); };
  const auto exact = [whole, frames](std::size_t i)
                         SLIPSTREAM_STEP { return whole_sums(whole, frames, i); };

  if (whole.empty()) {
    decode_with<0>(stage, any, saturation, row);
  } else {
    decode_with<0>(stage, exact, saturation, row);
  }
}

template <class Pixel>
HWY_NOINLINE void decode_pixels(const SinusoidStage& stage, const Pixel* const* frames,
                                const SinusoidRow& row) {
  // A local copy stays in registers: no store can alias it.
  const SinusoidRow local = row;
  const int steps = stage.cosines.empty() ? stage.steps : 0;

  if (steps == 3) return decode_closed_form<3>(stage, frames, local);
  if (steps == 4) return decode_closed_form<4>(stage, frames, local);
  if (steps == 5) return decode_closed_form<5>(stage, frames, local);
  if (steps == 6) return decode_closed_form<6>(stage, frames, local);
  decode_weighted(stage, frames, local);
}

void DecodeRow(const SinusoidStage& stage, const FrameRows& frames, const SinusoidRow& row) {
  std::visit([&](auto of) { decode_pixels(stage, of, row); }, frames);
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(DecodeRow);

void decode_row(const SinusoidStage& stage, const FrameRows& frames, const SinusoidRow& row) {
  HWY_DYNAMIC_DISPATCH(DecodeRow)(stage, frames, row);
}

}  // namespace slipstream
#endif
