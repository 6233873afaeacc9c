#include "slipstream/response.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "base/throw_if-inl.h"

namespace slipstream {
namespace {

/// The least-squares nearest rising sequence: neighbours out of order share their mean.
std::vector<double> nearest_rising(const std::vector<double>& sequence) {
  struct Run {
    double mean;
    std::size_t count;
  };

  std::vector<Run> runs;
  for (const double next : sequence) {
    runs.push_back({next, 1});
    // Merge a mean that is below the one before; the merged run may be out of order in turn.
    while (runs.size() > 1 && runs[runs.size() - 2].mean > runs.back().mean) {
      const Run last = runs.back();
      runs.pop_back();
      Run& before = runs.back();
      const std::size_t count = before.count + last.count;
      before.mean = (before.mean * static_cast<double>(before.count) +
                     last.mean * static_cast<double>(last.count)) /
                    static_cast<double>(count);
      before.count = count;
    }
  }

  std::vector<double> rising;
  for (const Run& run : runs) rising.insert(rising.end(), run.count, run.mean);

  return rising;
}

/// Slopes of the monotone cubic through the points (Fritsch and Butland: weighted harmonic mean of
/// the chords on both sides, 0 where one of them is flat).
std::vector<double> monotone_slopes(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t last = x.size() - 1;
  const auto width = [&](std::size_t i) { return x[i + 1] - x[i]; };
  const auto chord = [&](std::size_t i) { return (y[i + 1] - y[i]) / width(i); };

  // Inside: the weighted harmonic mean of both chords.
  std::vector<double> slopes(x.size());
  for (std::size_t i = 1; i < last; ++i) {
    const double left = chord(i - 1), right = chord(i);
    if (left <= 0 || right <= 0) continue;

    const double a = 2 * width(i) + width(i - 1), b = width(i) + 2 * width(i - 1);
    slopes[i] = (a + b) / (a / left + b / right);
  }

  // At the ends, the parabola through three points, clamped so that it does not overshoot.
  const auto end_slope = [](double near, double next, double near_width, double next_width) {
    const double slope =
        ((2 * near_width + next_width) * near - near_width * next) / (near_width + next_width);
    return std::clamp(slope, 0.0, 3 * near);
  };

  slopes[0] = end_slope(chord(0), chord(1), width(0), width(1));
  slopes[last] = end_slope(chord(last - 1), chord(last - 2), width(last - 1), width(last - 2));

  return slopes;
}

double light_at(const ResponseCurve& curve, double value) {
  const auto& x = curve.values;
  // The segment in which the value lies, and the place in it, t from 0 to 1.
  const auto i = std::upper_bound(x.begin() + 1, x.end() - 1, value) - x.begin() - 1;
  const double width = x[i + 1] - x[i];
  const double t = (value - x[i]) / width;
  const double u = 1 - t;

  // Cubic Hermite form.
  return curve.light[i] * u * u * (1 + 2 * t) + curve.light[i + 1] * t * t * (3 - 2 * t) +
         width * t * u * (curve.slopes[i] * u - curve.slopes[i + 1] * t);
}

double value_for(const ResponseCurve& curve, double light) {
  double low = 0, high = 1;
  // Bisection until no double lies between low and high.
  while (true) {
    const double middle = std::midpoint(low, high);
    if (middle == low || middle == high) return middle;
    (light_at(curve, middle) < light ? low : high) = middle;
  }
}

}  // namespace

bool is_linear(const Response& response) {
  const auto* const law = std::get_if<PowerLaw>(&response);
  return law != nullptr && law->gamma == 1;
}

void require_gamma(double gamma, std::string_view what) {
  throw_if(!(gamma >= least_gamma && gamma <= largest_gamma), "{} {} is out of range; {} to {}",
           what, gamma, least_gamma, largest_gamma);
}

ResponseCurve response_curve(std::span<const double> values, std::span<const double> intensities) {
  throw_if(
      values.size() < 3 || values.size() != intensities.size(),
      "response curve: {} values with {} intensities; expected at least 3, one intensity for each",
      values.size(), intensities.size());

  const auto finite = [](double number) { return std::isfinite(number); };
  throw_if(!std::ranges::all_of(values, finite) || !std::ranges::all_of(intensities, finite),
           "response curve: all numbers must be finite");

  // 1. The points in the order of their values, from 0 to 1 and each once.
  std::vector<std::pair<double, double>> points;
  for (std::size_t i = 0; i < values.size(); ++i) points.emplace_back(values[i], intensities[i]);
  std::ranges::sort(points);

  std::vector<double> x, light;
  for (const auto& [value, intensity] : points) {
    x.push_back(value);
    light.push_back(intensity);
  }

  throw_if(x.front() != 0 || x.back() != 1,
           "response curve: values go from {} to {}; expected 0 to 1", x.front(), x.back());

  const auto twice = std::ranges::adjacent_find(x);
  if (twice != x.end()) throw Error(fmt::format("response curve: value {} occurs twice", *twice));

  // 2. Noise must not make the light fall. Scaled to 0 to 1, ambient light and reflectivity cancel.
  light = nearest_rising(light);
  const double dark = light.front(), span = light.back() - dark;
  throw_if(!(span > 0), "response curve: the intensity does not rise with the pattern value");
  for (double& intensity : light) intensity = (intensity - dark) / span;

  // 3. A monotone cubic through the points.
  std::vector<double> slopes = monotone_slopes(x, light);
  return {std::move(x), std::move(light), std::move(slopes)};
}

double light_at(const Response& response, double value) {
  const double inside = std::clamp(value, 0.0, 1.0);
  if (const auto* law = std::get_if<PowerLaw>(&response)) return std::pow(inside, law->gamma);
  return light_at(std::get<ResponseCurve>(response), inside);
}

double value_for(const Response& response, double light) {
  const double inside = std::clamp(light, 0.0, 1.0);
  if (const auto* law = std::get_if<PowerLaw>(&response)) return std::pow(inside, 1 / law->gamma);
  return value_for(std::get<ResponseCurve>(response), inside);
}

}  // namespace slipstream
