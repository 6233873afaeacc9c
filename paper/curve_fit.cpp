#include "paper/curve_fit.h"

#include <numbers>

#include "response/response_fit.h"

namespace slipstream {
namespace {

/// A fit for one gamma, which leaves a straight line over x^gamma, and its squared distance.
struct LineFit {
  FittedGamma curve;
  double squares = 0;
};

LineFit fit_line(double gamma, const std::vector<double>& x, const std::vector<double>& grey) {
  const auto count = static_cast<double>(x.size());
  double sum_p = 0, sum_g = 0, sum_pp = 0, sum_pg = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double p = std::pow(x[i], gamma);
    sum_p += p;
    sum_g += grey[i];
    sum_pp += p * p;
    sum_pg += p * grey[i];
  }
  const double scale = (count * sum_pg - sum_p * sum_g) / (count * sum_pp - sum_p * sum_p);
  LineFit fit{{.gamma = gamma, .scale = scale, .offset = (sum_g - scale * sum_p) / count}};
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double distance = grey[i] - fit.curve.at(x[i]);
    fit.squares += distance * distance;
  }
  return fit;
}

}  // namespace

FittedGamma fit_gamma(const std::vector<double>& x, const std::vector<double>& grey_levels) {
  // Golden section search: the distance has one minimum over gamma.
  const double section = 1 / std::numbers::phi;
  double low = 0.5, high = 12;
  while (high - low > 1e-6) {
    const double left = high - section * (high - low), right = low + section * (high - low);
    const bool left_is_better =
        fit_line(left, x, grey_levels).squares < fit_line(right, x, grey_levels).squares;
    (left_is_better ? high : low) = left_is_better ? right : left;
  }
  return fit_line((low + high) / 2, x, grey_levels).curve;
}

}  // namespace slipstream
