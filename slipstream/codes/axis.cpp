#include "slipstream/codes/axis.h"

#include <string>

#include "slipstream/base/error.h"

namespace slipstream {

int length_along(Axis axis, Size projector) {
  return axis == Axis::x ? projector.width : projector.height;
}

std::string_view name_of(Axis axis) {
  return axis == Axis::x ? "x" : "y";
}

Axis axis_named(std::string_view name) {
  if (name == "x") return Axis::x;
  if (name == "y") return Axis::y;
  throw Error("axis '" + std::string(name) + "' is not known; it is x or y");
}

double coordinate_of_pixel(int index, int projector_length) {
  return static_cast<double>(index) / projector_length;
}

}  // namespace slipstream
