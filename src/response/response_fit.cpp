#include "response/response_fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "base/numbers.h"
#include "base/srgb.h"
#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

/// The curve through 129 points of an increasing function from 0 to 1.
template <class Function>
ResponseCurve through_points_of(const Function& light) {
  constexpr int last = 128;

  std::vector<double> values, intensities;
  for (int i = 0; i <= last; ++i) {
    values.push_back(static_cast<double>(i) / last);
    intensities.push_back(light(values.back()));
  }

  return response_curve(values, intensities);
}

/// Minimum of a unimodal function in [low, high].
template <class Function>
double lowest_between(const Function& f, double low, double high) {
  while (high - low > 1e-9) {
    // The minimum is never in the outer third next to the higher value.
    const double third = (high - low) / 3;
    if (f(low + third) < f(high - third)) {
      high -= third;
    } else {
      low += third;
    }
  }

  return std::midpoint(low, high);
}

/// Logarithm of the slope, and the centre. The search may leave the range of logistic_curve.
using Logistic = std::array<double, 2>;

double slope_of(const Logistic& logistic) {
  return std::clamp(std::exp(logistic[0]), 0.1, 50.0);
}

double centre_of(const Logistic& logistic) {
  return std::clamp(logistic[1], 0.0, 1.0);
}

ResponseCurve curve_of(const Logistic& logistic) {
  return logistic_curve(slope_of(logistic), centre_of(logistic));
}

/// Local minimum near `place`, by coordinate descent with decreasing steps.
template <class Function>
Logistic lowest_near(const Function& f, Logistic place) {
  double least = f(place);
  for (double step = 0.2; step > 1e-4; step /= 2) {
    // Until both directions along both axes fail in a row.
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

LevelFit fit_levels(const Response& response, std::span<const double> values,
                    std::span<const double> intensities) {
  const auto count = static_cast<double>(values.size());
  LevelFit fit;

  double x = 0, y = 0, xx = 0, xy = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double light = fit.left.emplace_back(light_at(response, values[i]));
    x += light;
    y += intensities[i];
    xx += light * light;
    xy += light * intensities[i];
  }

  // Slope and intercept of the line through the points (light, intensity).
  fit.scale = (count * xy - x * y) / (count * xx - x * x);
  fit.offset = (y - fit.scale * x) / count;

  double sum = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    fit.left[i] = intensities[i] - fit.scale * fit.left[i] - fit.offset;
    sum += fit.left[i] * fit.left[i];
  }
  fit.rms = std::sqrt(sum / count);

  return fit;
}

/// Whether the residual is noise (von Neumann ratio: 2 for noise, 0 for a smooth curve), or below
/// any noise.
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

ResponseCurve srgb_curve() {
  return through_points_of(linear_of_srgb);
}

ResponseCurve logistic_curve(double slope, double centre) {
  throw_if(!(slope > 0 && slope <= 50 && centre >= 0 && centre <= 1),
           "logistic curve: slope {} or centre {} is out of range; slope 0 to 50, centre 0 to 1",
           slope, centre);
  return through_points_of(
      [&](double value) { return 1 / (1 + std::exp(-slope * (value - centre))); });
}

std::optional<ResponseCurve> curve_named(std::string_view name) {
  constexpr std::string_view logistic = "logistic:";

  if (name == "srgb") return srgb_curve();
  if (!name.starts_with(logistic)) return std::nullopt;

  const auto numbers = numbers_in<double>(name.substr(logistic.size()), ':');
  if (numbers.size() == 2) return logistic_curve(numbers[0], numbers[1]);
  throw Error(fmt::format("{}: expected two numbers, e.g. logistic:9:0.45", name));
}

GammaFit fit_gamma(std::span<const double> values, std::span<const double> intensities) {
  throw_if(values.size() < 4 || values.size() != intensities.size(),
           "{} uniform patterns with {} intensities; fitting gamma requires at least 4",
           values.size(), intensities.size());

  const auto [least, most] = std::ranges::minmax_element(values);
  throw_if(*least == *most, "uniform patterns: all have the value {}; use several", *least);

  const auto fit_at = [&](double gamma) {
    return fit_levels(PowerLaw{gamma}, values, intensities);
  };

  const double gamma = lowest_between([&](double trial) { return fit_at(trial).rms; },
                                      least_gamma / 2, 2 * largest_gamma);

  const GammaFit fit{fit_at(gamma), gamma};
  throw_if(!(fit.scale > 0),
           "uniform patterns: the intensity does not rise with the pattern value");

  return fit;
}

std::optional<NamedResponse> curve_that_serves(
    const std::function<double(const Response&)>& distance,
    const std::function<bool(const Response&)>& serves) {
  const Response srgb = srgb_curve();
  if (serves(srgb)) return NamedResponse{"srgb", srgb};

  // The search starts at a slope of 6 around the middle.
  const Logistic nearest = lowest_near(
      [&](const Logistic& logistic) { return distance(curve_of(logistic)); }, {std::log(6), 0.5});
  const Response s_curve = curve_of(nearest);
  if (!serves(s_curve)) return std::nullopt;

  return NamedResponse{fmt::format("logistic:{:.4g}:{:.4g}", slope_of(nearest), centre_of(nearest)),
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
