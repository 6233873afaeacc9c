#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/response.h"

namespace slipstream {

/// Light of an sRGB display (IEC 61966-2-1): linear near black, then a power of 2.4.
ResponseCurve srgb_curve();

/// The S-curve 1 / (1 + exp(-slope (value - centre))), scaled to 0 to 1. Throws Error unless the
/// slope is in (0, 50] and the centre in [0, 1].
ResponseCurve logistic_curve(double slope, double centre);

/// The curve named "srgb" or "logistic:SLOPE:CENTRE"; nullopt for any other text. Throws as
/// logistic_curve.
std::optional<ResponseCurve> curve_named(std::string_view name);

/// Fit of scale light + offset, with the light of a response, to the intensities (grey levels) of
/// uniform patterns with given values, [0, 1].
struct LevelFit {
  double scale = 0;            ///< grey levels
  double offset = 0;           ///< grey levels: ambient light
  double rms = 0;              ///< residual, grey levels
  std::vector<double> left{};  ///< residual of each level, grey levels
};

/// The traditional measurement (4.2): the fit for value^gamma.
struct GammaFit : LevelFit {
  double gamma = 1;
};

/// Least squares. Throws Error for fewer than 4 values, equal values, or intensities that do not
/// increase.
GammaFit fit_gamma(std::span<const double> values, std::span<const double> intensities);

/// A response and its name: "power law", one of curve_named, or "measured curve".
struct NamedResponse {
  std::string name;
  Response response;
};

/// The first that `serves`: sRGB, then the S-curve (logistic) with the least `distance`.
std::optional<NamedResponse> curve_that_serves(
    const std::function<double(const Response&)>& distance,
    const std::function<bool(const Response&)>& serves);

/// The simplest response whose residual is noise, for the intensities (grey levels) of uniform
/// patterns with those values, [0, 1], increasing: a power law, sRGB, an S-curve, or otherwise the
/// curve through them. Noise varies from level to level; with a wrong shape, neighbouring residuals
/// are similar. Throws Error as fit_gamma and response_curve.
NamedResponse simplest_response(std::span<const double> values,
                                std::span<const double> intensities);

}  // namespace slipstream
