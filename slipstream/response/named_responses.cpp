#include "slipstream/response/named_responses.h"

#include <cmath>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/number_text.h"

namespace slipstream {
namespace {

/// The curve through 129 points of a function that rises from 0 to 1.
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

}  // namespace

ResponseCurve srgb_curve() {
  return through_points_of([](double value) {
    return value <= 0.04045 ? value / 12.92 : std::pow((value + 0.055) / 1.055, 2.4);
  });
}

ResponseCurve logistic_curve(double slope, double centre) {
  if (!(slope > 0 && slope <= 50 && centre >= 0 && centre <= 1)) {
    throw Error(fmt::format(
        "logistic curve of slope {} and centre {}: slope 0 to 50, centre 0 to 1", slope, centre));
  }
  return through_points_of(
      [&](double value) { return 1 / (1 + std::exp(-slope * (value - centre))); });
}

std::optional<ResponseCurve> curve_named(std::string_view name) {
  constexpr std::string_view logistic = "logistic:";
  if (name == "srgb") return srgb_curve();
  if (!name.starts_with(logistic)) return std::nullopt;
  const auto numbers = numbers_in<double>(name.substr(logistic.size()), ':');
  if (numbers.size() == 2) return logistic_curve(numbers[0], numbers[1]);
  throw Error(fmt::format("{}: two numbers are wanted, as in logistic:9:0.45", name));
}

}  // namespace slipstream
