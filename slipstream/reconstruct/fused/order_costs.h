#pragma once

#include <cstdint>
#include <vector>

// What sinusoid_rows.h says of its functions holds for these.
namespace slipstream {

/// How frames with a cue say what a fringe order costs: CueEvidence::cost.
struct OrderCostStage {
  /// What a frame counts for in C, S, and in the cue's channel or its cosine and sine.
  std::vector<double> cosines{}, sines{}, cue{}, cue_sine{};
  enum class Cue { linear, cosine, circle };
  Cue form = Cue::linear;
  float share = 1, cue_share = 1;  ///< c_1, c_2
  float constant_light = 0, steady = 0, component_variance = 1, cue_variance = 1;
  float periods = 12;  ///< f_h
  float margin = 0;    ///< how far past the field a coordinate may lie: CueEvidence::near_field
};

/// What it costs a pixel to be one period below or above its own fringe order, less what that one
/// costs; infinite past the field.
struct OrderCosts {
  float *below = nullptr, *above = nullptr;  ///< of the pixels of a row
};

inline constexpr int costed_together = 16;

/// Of `costed_together` pixels. `to_8_bits`: a grey level of the frames in those of an 8-bit
/// device; `coordinate`: by their own orders; where it is NaN the costs mean nothing.
void order_costs(const OrderCostStage& stage, float to_8_bits, const std::uint8_t* const* frames,
                 const float* coordinate, const OrderCosts& costs);
void order_costs(const OrderCostStage& stage, float to_8_bits, const std::uint16_t* const* frames,
                 const float* coordinate, const OrderCosts& costs);

}  // namespace slipstream
