#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>

#include "slipstream/codes/response.h"

namespace slipstream {

/// A response and its name: "power law", one of curve_named, or "measured curve".
struct NamedResponse {
  std::string name;
  Response response;
};

/// sRGB, else the S-curve (logistic) at which `distance` is least, whichever `serves` first.
std::optional<NamedResponse> curve_that_serves(
    const std::function<double(const Response&)>& distance,
    const std::function<bool(const Response&)>& serves);

/// The simplest response that leaves nothing but noise of the intensities (grey levels) seen at
/// uniform patterns of those values, [0, 1], rising: a power law, sRGB, an S-curve, or else the
/// curve through them. Noise is what differs from level to level; where a shape is wrong,
/// neighbours err alike. Throws Error as fit_gamma and response_curve.
NamedResponse simplest_response(std::span<const double> values,
                                std::span<const double> intensities);

}  // namespace slipstream
