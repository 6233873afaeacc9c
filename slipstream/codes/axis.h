#pragma once

#include <string_view>

#include "slipstream/base/size.h"

namespace slipstream {

/// The projector axis along which a pattern varies. `x`: the intensity is a function of the
/// projector column (stripes stand upright); `y`: of the projector row, as in Liu 2010.
enum class Axis { x, y };

/// Projector pixels along the axis: the width for `x`, the height for `y`.
int length_along(Axis axis, Size projector);

/// The other one.
constexpr Axis across(Axis axis) {
  return axis == Axis::x ? Axis::y : Axis::x;
}

/// "x" or "y".
std::string_view name_of(Axis axis);

/// The axis of that name. Throws Error for any name but "x" and "y".
Axis axis_named(std::string_view name);

/// Projector coordinate, in [0, 1) across the field, of the centre of a pixel: index /
/// projector_length.
double coordinate_of_pixel(int index, int projector_length);

}  // namespace slipstream
