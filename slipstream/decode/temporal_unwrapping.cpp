#include "slipstream/decode/temporal_unwrapping.h"

#include <cmath>
#include <numbers>

namespace slipstream {

using std::numbers::pi;

int fringe_order(double wrapped_phase, double frequency, double coarse_coordinate) {
  return static_cast<int>(std::lround(coarse_coordinate * frequency - wrapped_phase / (2 * pi)));
}

double fringe_order_residual(double wrapped_phase, double frequency, double coarse_coordinate,
                             int fringe_order) {
  return coarse_coordinate * frequency - wrapped_phase / (2 * pi) - fringe_order;
}

double unwrapped_coordinate(double wrapped_phase, int fringe_order, double frequency) {
  return (wrapped_phase + 2 * pi * fringe_order) / (2 * pi * frequency);
}

double coordinate_in_field(double coordinate, double period, int projector_length) {
  const double unlit = period - 1;
  const double cut = -0.5 / projector_length - unlit / 2;
  return coordinate - period * std::floor((coordinate - cut) / period);
}

}  // namespace slipstream
