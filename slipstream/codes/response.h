#pragma once

#include <span>
#include <string_view>
#include <variant>
#include <vector>

namespace slipstream {

/// Range of gamma that slipstream models, measures and corrects.
inline constexpr double least_gamma = 0.5;
inline constexpr double largest_gamma = 11;

/// The projector's light is its pattern's value to the power gamma: Liu 2010, Eq. (4.2).
struct PowerLaw {
  double gamma = 1;

  friend bool operator==(const PowerLaw&, const PowerLaw&) = default;
};

/// A measured response: monotone cubic from pattern value to light, both 0 to 1, rising throughout.
struct ResponseCurve {
  std::vector<double> values;  ///< of the pattern, from 0 to 1, rising
  std::vector<double> light;   ///< at each of them, from 0 to 1, rising
  std::vector<double> slopes;  ///< of the curve there, d light / d value

  friend bool operator==(const ResponseCurve&, const ResponseCurve&) = default;
};

/// How the light of projector and camera together answers a pattern's value.
using Response = std::variant<PowerLaw, ResponseCurve>;

/// Whether light is the pattern's value itself: a power law of 1.
bool is_linear(const Response& response);

/// A response and how well it is known.
struct MeasuredResponse {
  Response response{};
  double gamma = 1;           ///< of the power law, or of the one nearest to a curve
  double standard_error = 0;  ///< of gamma; 0 where not known

  friend bool operator==(const MeasuredResponse&, const MeasuredResponse&) = default;
};

/// Throws Error, naming `what`, unless gamma is in [least_gamma, largest_gamma].
void require_gamma(double gamma, std::string_view what);

/// The curve through camera intensities (grey levels) measured at uniform patterns of those values,
/// [0, 1] of the projector's range, in any order; scaled to 0 to 1, so that ambient light and
/// reflectivity drop out. Neighbours in the wrong order, by noise, are averaged. Throws Error
/// unless there are 3 or more different values, 0 and 1 among them, and the intensity rises from 0
/// to 1.
ResponseCurve response_curve(std::span<const double> values, std::span<const double> intensities);

/// Light, [0, 1], at a pattern's value; values outside [0, 1] are taken for the nearest inside.
double light_at(const Response& response, double value);

/// The value, [0, 1], whose light that is: the inverse of light_at.
double value_for(const Response& response, double light);

}  // namespace slipstream
