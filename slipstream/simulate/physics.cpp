#include "slipstream/simulate/physics.h"

#include <cmath>

namespace slipstream {

double Sharpness::at(double distance) const {
  return std::hypot(blur, defocus * (distance - 1));
}

}  // namespace slipstream
