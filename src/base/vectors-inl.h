// Vectors of pixels, several at a time. Included once for each vector target.
#if defined(SLIPSTREAM_KERNELS_VECTORS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef SLIPSTREAM_KERNELS_VECTORS_INL_H_
#undef SLIPSTREAM_KERNELS_VECTORS_INL_H_
#else
#define SLIPSTREAM_KERNELS_VECTORS_INL_H_
#endif

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include <hwy/cache_control.h>
#include <hwy/contrib/math/math-inl.h>
#include <hwy/highway.h>

/// For lambdas in kernels: compiled for the vector target and always inlined.
#ifndef SLIPSTREAM_STEP
#define SLIPSTREAM_STEP HWY_ATTR __attribute__((always_inline))
#endif

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using FloatTag = hn::ScalableTag<float>;
using IntTag = hn::RebindToSigned<FloatTag>;
using Floats = hn::Vec<FloatTag>;
using Ints = hn::Vec<IntTag>;
using FloatMask = hn::Mask<FloatTag>;

/// Calls `body(i)` for each vector of a row; the last overlaps the one before it if the width is
/// not a multiple of the vector.
template <class Body>
HWY_INLINE void for_each_vector(int width, const Body& body) {
  const auto count = static_cast<std::size_t>(width);
  const std::size_t lanes = hn::Lanes(FloatTag());
  // A single call site, so that the body is inlined and its constants stay in registers.
  for (std::size_t next = 0; next < count; next += lanes) body(std::min(next, count - lanes));
}

/// Vectors processed together, to hide the latency of dependent operations. With AVX2 four no
/// longer fit in the registers, but take 0.85 of the time of two on an AMD EPYC.
#if HWY_MAX_BYTES >= 32
inline constexpr std::size_t at_once = 4;
#else
inline constexpr std::size_t at_once = 2;
#endif

/// For bodies whose values would otherwise not fit in the registers.
inline constexpr std::size_t few_at_once = 2;

template <std::size_t count>
using Together = std::integral_constant<std::size_t, count>;

/// Calls `body(Together<count>(), i)` for `count` vectors from pixel i on, covering the row: `most`
/// vectors at a time, then single ones. The last overlap those before if the width is not a
/// multiple of the vector.
template <std::size_t most = at_once, class Body>
HWY_INLINE void for_each_group(std::size_t width, const Body& body) {
  const std::size_t lanes = hn::Lanes(FloatTag()), together = most * lanes;
  std::size_t i = 0;
  for (; i + together <= width; i += together) body(Together<most>(), i);
  for (; i < width; i += lanes) body(Together<1>(), std::min(i, width - lanes));
}

/// An array of vectors: std::array is not compiled for each target.
template <std::size_t count, class Vector = Floats>
class Several {
 public:
  HWY_INLINE Several() {}
  HWY_INLINE Vector& operator[](std::size_t k) { return vectors_[k]; }
  HWY_INLINE const Vector& operator[](std::size_t k) const { return vectors_[k]; }

 private:
  Vector vectors_[count];  // NOLINT(modernize-avoid-c-arrays)
};

/// Applies one step to each of them, unrolled so that all stay in registers.
template <std::size_t count, class Step>
HWY_INLINE void each(const Step& step) {
  HWY_UNROLL(16) for (std::size_t k = 0; k < count; ++k) step(k);
}

/// Stores a vector. `past_cache` uses streaming stores, which do not first read an image too large
/// for the cache; `to` must then be aligned to eight floats.
HWY_INLINE void store(Floats values, float* to, bool past_cache) {
  const FloatTag d;

  if (!past_cache) return hn::StoreU(values, d, to);
#if HWY_MAX_BYTES == 64
  if (reinterpret_cast<std::uintptr_t>(to) % 64 != 0) {
    const hn::Half<FloatTag> half;
    hn::Stream(hn::LowerHalf(half, values), half, to);
    return hn::Stream(hn::UpperHalf(half, values), half, to + hn::Lanes(half));
  }
#endif

  hn::Stream(values, d, to);
}

/// Prefetches memory soon to be written after `to`: a store waits for its cache line.
template <class Value>
HWY_INLINE void fetch_ahead(const Value* to, bool past_cache) {
  constexpr std::uintptr_t bytes_ahead = 512;  // may lie past the array; not accessed
  if (past_cache) return;
  hwy::Prefetch(reinterpret_cast<const Value*>(reinterpret_cast<std::uintptr_t>(to) + bytes_ahead));
}

/// a / b to within one or two units in the last place: approximate reciprocal and one correction,
/// in a third of a division's time.
HWY_INLINE Floats quotient(Floats a, Floats b) {
#if HWY_ARCH_X86
  const Floats r = hn::ApproximateReciprocal(b);
  const Floats q = hn::Mul(a, r);
  return hn::MulAdd(r, hn::NegMulAdd(b, q, a), q);
#else
  return hn::Div(a, b);
#endif
}

/// a / b for each.
template <std::size_t count>
HWY_INLINE Several<count> quotients(const Several<count>& a, const Several<count>& b) {
  Several<count> q;
#if HWY_ARCH_X86
  Several<count> r;
  each<count>([&](std::size_t k) SLIPSTREAM_STEP { r[k] = hn::ApproximateReciprocal(b[k]); });
  each<count>([&](std::size_t k) SLIPSTREAM_STEP { q[k] = hn::Mul(a[k], r[k]); });
  each<count>([&](std::size_t k) SLIPSTREAM_STEP {
    q[k] = hn::MulAdd(r[k], hn::NegMulAdd(b[k], q[k], a[k]), q[k]);
  });
#else
  each<count>([&](std::size_t k) SLIPSTREAM_STEP { q[k] = hn::Div(a[k], b[k]); });
#endif
  return q;
}

/// sum = sum x + c for each.
template <std::size_t count>
HWY_INLINE void add_term(Several<count>& sum, const Several<count>& x, float c) {
  each<count>([&](std::size_t k)
                  SLIPSTREAM_STEP { sum[k] = hn::MulAdd(sum[k], x[k], hn::Set(FloatTag(), c)); });
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif
