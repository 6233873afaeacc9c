#pragma once

#include <optional>
#include <string_view>

#include "slipstream/codes/response.h"

namespace slipstream {

/// Light of a display that follows sRGB (IEC 61966-2-1): a line near black, then a power of 2.4.
ResponseCurve srgb_curve();

/// The S-curve 1 / (1 + exp(-slope (value - centre))), scaled to go from 0 to 1. Throws Error
/// unless the slope is in (0, 50] and the centre in [0, 1].
ResponseCurve logistic_curve(double slope, double centre);

/// The curve of the name "srgb" or "logistic:SLOPE:CENTRE"; nothing for any other text. Throws as
/// logistic_curve.
std::optional<ResponseCurve> curve_named(std::string_view name);

}  // namespace slipstream
