#pragma once

#include "reconstruct/fused/stage_numbers.h"

namespace slipstream {

/// Stage of a band of `frequency` periods whose coordinate is known up to 1 / `widest`.
CoordinateStage coordinate_stage(double frequency, double widest, int projector_length);

}  // namespace slipstream
