// Frames of more than 8 bits, which take the compiler as long as those of 8: sinusoid_rows.cpp.
#include <cstdint>

#include "slipstream/base/disabled_targets-inl.h"
#include "slipstream/reconstruct/fused/sinusoid_rows.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slipstream/reconstruct/fused/sinusoid_rows_16.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "slipstream/reconstruct/fused/sinusoid_decode-inl.h"

HWY_BEFORE_NAMESPACE();
namespace slipstream::HWY_NAMESPACE {

void DecodeRow16(const SinusoidStage& stage, const SinusoidLimits& limits,
                 const std::uint16_t* const* frames, const SinusoidRow& row) {
  decode_pixels(stage, limits, frames, row);
}

}  // namespace slipstream::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(DecodeRow16);

void decode_row(const SinusoidStage& stage, const SinusoidLimits& limits,
                const std::uint16_t* const* frames, const SinusoidRow& row) {
  HWY_DYNAMIC_DISPATCH(DecodeRow16)(stage, limits, frames, row);
}

}  // namespace slipstream
#endif
