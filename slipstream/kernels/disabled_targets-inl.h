#pragma once

// Before any header of Highway: targets that are not compiled. SSSE3 is older than any machine that
// is worth it, AVX3_DL has nothing more that is used here, and vectors whose length the compiler
// does not know (SVE, RVV) cannot be members of a class.
#define HWY_DISABLED_TARGETS \
  (HWY_SSSE3 | HWY_AVX3_DL | HWY_SVE | HWY_SVE2 | HWY_SVE_256 | HWY_SVE2_128 | HWY_RVV)
