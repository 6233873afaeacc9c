#pragma once

#include <span>
#include <string_view>
#include <variant>
#include <vector>

namespace slipstream {

/// Range of gamma that is modelled, measured and corrected.
inline constexpr double least_gamma = 0.5;
inline constexpr double largest_gamma = 11;

/// The projector's light is the pattern value to the power gamma: Liu 2010, Eq. (4.2).
struct PowerLaw {
  double gamma = 1;

  friend bool operator==(const PowerLaw&, const PowerLaw&) = default;
};

/// A measured response: monotone cubic from pattern value to light, both 0 to 1, increasing.
struct ResponseCurve {
  std::vector<double> values;  ///< pattern values, from 0 to 1, increasing
  std::vector<double> light;   ///< at each value, from 0 to 1, increasing
  std::vector<double> slopes;  ///< of the curve, d light / d value

  friend bool operator==(const ResponseCurve&, const ResponseCurve&) = default;
};

/// Combined response of projector and camera: pattern value to light.
using Response = std::variant<PowerLaw, ResponseCurve>;

/// Whether light equals the pattern value: gamma 1.
bool is_linear(const Response& response);

/// A response and its uncertainty.
struct MeasuredResponse {
  Response response{};
  double gamma = 1;           ///< of the power law, or of the one nearest to a curve
  double standard_error = 0;  ///< of gamma; 0 if unknown

  friend bool operator==(const MeasuredResponse&, const MeasuredResponse&) = default;
};

/// Throws Error, beginning with `what`, unless gamma is in [least_gamma, largest_gamma].
void require_gamma(double gamma, std::string_view what);

/// The curve through camera intensities (grey levels) of uniform patterns with those values, [0, 1]
/// of the projector's range, in any order; scaled to 0 to 1, so that ambient light and reflectivity
/// cancel. Neighbours out of order, because of noise, are averaged. Throws Error unless there are 3
/// or more different values, 0 and 1 among them, and the intensity rises from 0 to 1.
ResponseCurve response_curve(std::span<const double> values, std::span<const double> intensities);

/// Light, [0, 1], at a pattern value; values are clamped to [0, 1].
double light_at(const Response& response, double value);

/// Inverse of light_at: the pattern value, [0, 1], for that light.
double value_for(const Response& response, double light);

}  // namespace slipstream
