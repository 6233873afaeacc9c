#pragma once

// Before any header of Highway: targets that are not compiled. SSSE3 is older than any machine that
// is worth it, AVX3_DL has nothing more that is used here, and vectors whose length the compiler
// does not know (SVE, RVV) cannot be members of a class.
#define SLIPSTREAM_UNUSED_TARGETS \
  (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)

// Sanitized builds have AVX2 and what any machine has: the other targets come from the same source,
// and they take long to compile.
#ifdef SLIPSTREAM_TWO_VECTOR_TARGETS
#define HWY_DISABLED_TARGETS (SLIPSTREAM_UNUSED_TARGETS | HWY_SSE4 | HWY_AVX3)
#else
#define HWY_DISABLED_TARGETS SLIPSTREAM_UNUSED_TARGETS
#endif
