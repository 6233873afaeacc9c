#include "slipstream/response/response_fit.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "slipstream/response/measurement.h"
#include "slipstream/response/named_responses.h"

namespace slipstream {
namespace {

/// Logarithm of the slope, and the centre.
using Logistic = std::array<double, 2>;

ResponseCurve curve_of(const Logistic& logistic) {
  return logistic_curve(std::clamp(std::exp(logistic[0]), 0.1, 50.0),
                        std::clamp(logistic[1], 0.0, 1.0));
}

/// The lowest place of a function near `place`, by steps along each axis that become shorter.
template <class Function>
Logistic lowest_near(const Function& f, Logistic place) {
  double least = f(place);
  for (double step = 0.2; step > 1e-4; step /= 2) {
    for (std::size_t tried = 0, axis = 0; tried < 2 * place.size(); ++tried, ++axis) {
      for (const double by : {step, -step}) {
        Logistic next = place;
        next[axis % next.size()] += by;
        const double value = f(next);
        if (value >= least) continue;
        place = next;
        least = value;
        tried = 0;
        break;
      }
    }
  }
  return place;
}

/// Whether what a response leaves of the levels is noise (von Neumann's ratio, 2 for noise, 0 for
/// a smooth curve), or less than any noise.
bool leaves_noise(const LevelFit& fit) {
  constexpr double least_ratio = 1.2, negligible = 5e-4;
  double squares = 0, differences = 0;
  for (std::size_t i = 0; i < fit.left.size(); ++i) {
    squares += fit.left[i] * fit.left[i];
    if (i > 0) differences += std::pow(fit.left[i] - fit.left[i - 1], 2);
  }
  return differences >= least_ratio * squares || fit.rms <= negligible * fit.scale;
}

}  // namespace

std::optional<NamedResponse> curve_that_serves(
    const std::function<double(const Response&)>& distance,
    const std::function<bool(const Response&)>& serves) {
  const Response srgb = srgb_curve();
  if (serves(srgb)) return NamedResponse{"srgb", srgb};
  const Logistic nearest = lowest_near(
      [&](const Logistic& logistic) { return distance(curve_of(logistic)); }, {std::log(6), 0.5});
  const Response s_curve = curve_of(nearest);
  if (!serves(s_curve)) return std::nullopt;
  return NamedResponse{fmt::format("logistic:{:.4g}:{:.4g}", std::exp(nearest[0]), nearest[1]),
                       s_curve};
}

NamedResponse simplest_response(std::span<const double> values,
                                std::span<const double> intensities) {
  const double gamma = fit_gamma(values, intensities).gamma;
  const Response law = PowerLaw{std::clamp(gamma, least_gamma, largest_gamma)};
  const auto fit = [&](const Response& response) {
    return fit_levels(response, values, intensities);
  };
  if (leaves_noise(fit(law))) return {"power law", law};
  const auto curve =
      curve_that_serves([&](const Response& response) { return fit(response).rms; },
                        [&](const Response& response) { return leaves_noise(fit(response)); });
  return curve.value_or(NamedResponse{"measured curve", response_curve(values, intensities)});
}

}  // namespace slipstream
