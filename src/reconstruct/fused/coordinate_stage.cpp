#include "reconstruct/fused/coordinate_stage.h"

#include "reconstruct/fused/narrow.h"

namespace slipstream {

CoordinateStage coordinate_stage(double frequency, double widest, int projector_length) {
  const double period = 1 / widest;

  // The field begins half a pixel before the first pixel's centre. A longer period reaches as
  // far past one end of the field as past the other.
  return placing(narrow(1 / frequency), narrow(period),
                 narrow(-0.5 / projector_length - (period - 1) / 2));
}

}  // namespace slipstream
