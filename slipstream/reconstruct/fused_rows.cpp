#include "slipstream/reconstruct/fused_rows.h"

#include "slipstream/reconstruct/disabled_targets-inl.h"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "slipstream/reconstruct/fused_rows.cpp"
#include <hwy/cache_control.h>
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#include "slipstream/reconstruct/multiplexed_rows-inl.h"
#include "slipstream/reconstruct/point_rows-inl.h"
#include "slipstream/reconstruct/sinusoid_rows-inl.h"

#if HWY_ONCE
namespace slipstream {

HWY_EXPORT(DecodeRow8);
HWY_EXPORT(DecodeRow16);
HWY_EXPORT(DecodeMultiplexedRow8);
HWY_EXPORT(DecodeMultiplexedRow16);
HWY_EXPORT(FindDisagreeing);
HWY_EXPORT(PlaceRow);
HWY_EXPORT(UnwrapRow);
HWY_EXPORT(PhaseRow);
HWY_EXPORT(PointRowAlone);
HWY_EXPORT(PointRowConfirmed);

void decode_row(const SinusoidStage& stage, const SinusoidLimits& limits,
                const std::uint8_t* const* frames, const SinusoidRow& row) {
  HWY_DYNAMIC_DISPATCH(DecodeRow8)(stage, limits, frames, row);
}

void decode_row(const SinusoidStage& stage, const SinusoidLimits& limits,
                const std::uint16_t* const* frames, const SinusoidRow& row) {
  HWY_DYNAMIC_DISPATCH(DecodeRow16)(stage, limits, frames, row);
}

void decode_row(const SinusoidStage& stage, const CueStage& cue, const SinusoidLimits& limits,
                const CueLimits& cue_limits, const std::uint8_t* const* frames,
                const MultiplexedRow& row) {
  HWY_DYNAMIC_DISPATCH(DecodeMultiplexedRow8)(stage, cue, limits, cue_limits, frames, row);
}

void decode_row(const SinusoidStage& stage, const CueStage& cue, const SinusoidLimits& limits,
                const CueLimits& cue_limits, const std::uint16_t* const* frames,
                const MultiplexedRow& row) {
  HWY_DYNAMIC_DISPATCH(DecodeMultiplexedRow16)(stage, cue, limits, cue_limits, frames, row);
}

void find_disagreeing(const CueStage& cue, const CoordinateRows& rows,
                      std::vector<PixelPlace>& found) {
  HWY_DYNAMIC_DISPATCH(FindDisagreeing)(cue, rows, found);
}

void place_row(const CoordinateStage& stage, int width, const float* turn, float* coordinate) {
  HWY_DYNAMIC_DISPATCH(PlaceRow)(stage, width, turn, coordinate);
}

void unwrap_row(const UnwrapStage& stage, int width, const float* high_turn, const float* low_turn,
                std::int32_t hidden, const UnwrappedRow& row) {
  HWY_DYNAMIC_DISPATCH(UnwrapRow)(stage, width, high_turn, low_turn, hidden, row);
}

void flush_past_cache() {
  hwy::FlushStream();
}

void phase_row(int width, const float* turn, float* phase) {
  HWY_DYNAMIC_DISPATCH(PhaseRow)(width, turn, phase);
}

void point_row(const PointStage& stage, const CoordinateStage& coordinate, const PointRow& row) {
  HWY_DYNAMIC_DISPATCH(PointRowAlone)(stage, coordinate, row);
}

void point_row(const PointStage& stage, const ConsensusStage& consensus, const PointRow& row) {
  HWY_DYNAMIC_DISPATCH(PointRowConfirmed)(stage, consensus, row);
}

}  // namespace slipstream
#endif
