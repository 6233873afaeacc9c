#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

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

/// The intensities (grey levels) seen at uniform patterns of those values, [0, 1], fitted by
/// scale light + offset, the light being that of a response.
struct LevelFit {
  double scale = 0;            ///< grey levels
  double offset = 0;           ///< grey levels: ambient light
  double rms = 0;              ///< of what the curve leaves, grey levels
  std::vector<double> left{};  ///< that of each level, grey levels
};

/// The traditional measurement (4.2): the same by value^gamma.
struct GammaFit : LevelFit {
  double gamma = 1;
};

/// Least squares. Throws Error for fewer than 4 values, values that are all one, or intensities
/// that do not rise.
GammaFit fit_gamma(std::span<const double> values, std::span<const double> intensities);

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
