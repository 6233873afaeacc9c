#include "slipstream/strategy/multiplexing_design.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "slipstream/error/error.h"
#include "slipstream/noise/predicted_variance.h"

namespace slipstream {
namespace {

using std::numbers::pi;

/// Probability that a standard normal number is above x.
double upper_tail(double x) {
  return 0.5 * std::erfc(x / std::numbers::sqrt2);
}

double reference_sigma(const PhaseChannelMultiplexing& strategy, const PatternLight& light,
                       double alpha, double ambient, double noise_variance, double R) {
  const double variance =
      strategy.steps == 3 ? dc_reference_variance(alpha, light, ambient, strategy.c1(), R)
                          : half_phase_reference_variance(alpha, light.alpha_p, strategy.c1(), R);
  return std::sqrt(noise_variance * variance);
}

/// The design of least noise at f_h that meets the goal: c_1 as large as it can be.
std::optional<Design> design_at(const DesignGoal& goal, const PatternLight& light, int f_h) {
  for (int hundredths = 95; hundredths > 0; --hundredths) {
    const double c1 = 0.01 * hundredths;
    if (c1 * f_h <= 1) return std::nullopt;  // (3.64)
    const PhaseChannelMultiplexing strategy{
        .steps = goal.steps, .high = f_h, .share = c1, .reference = {}};
    const double success =
        predicted_unwrapping(strategy, light, goal.alpha, goal.ambient, goal.noise_variance);
    if (success < goal.success) continue;
    const double variance =
        strategy.coordinate_variance(goal.alpha, light.alpha_p, goal.noise_variance);
    return Design{.strategy = strategy,
                  .light = light,
                  .success = success,
                  .coordinate_sigma = std::sqrt(variance)};
  }
  return std::nullopt;
}

}  // namespace

void require_valid(const DesignGoal& goal) {
  const auto require = [](bool holds, std::string_view name, double value, std::string_view range) {
    if (!holds) throw Error(fmt::format("{} {} is out of range; {}", name, value, range));
  };
  require(goal.steps >= 3 && goal.steps <= 64, "steps", goal.steps, "3 to 64");
  require(goal.alpha > 0 && goal.alpha <= 1, "reflectivity", goal.alpha, "above 0, at most 1");
  require(std::abs(goal.ambient) <= 255, "ambient light", goal.ambient, "-255 to 255");
  require(goal.noise_variance > 0 && std::isfinite(goal.noise_variance), "noise variance",
          goal.noise_variance, "above 0");
  require(goal.success >= 0.5 && goal.success < 1, "success", goal.success,
          "0.5 and more, below 1");
  require(goal.most_periods >= 2 && goal.most_periods <= 1000, "most periods", goal.most_periods,
          "2 to 1000");
}

double predicted_unwrapping(const PhaseChannelMultiplexing& strategy, const PatternLight& light,
                            double alpha, double ambient, double noise_variance) {
  const double f_h = strategy.f_h();
  if (strategy.steps >= 5) {
    const double variance =
        cue_phase_variance(strategy.steps, alpha, light.alpha_p, strategy.c2(), noise_variance);
    return 1 - 2 * upper_tail(pi / f_h / std::sqrt(variance));
  }
  constexpr int places = 400;
  double sum = 0;
  for (int place = 0; place < places; ++place) {
    const double y = (place + 0.5) / places;
    const double R = strategy.R(y);
    const double sigma = reference_sigma(strategy, light, alpha, ambient, noise_variance, R);
    const auto missed = [&](double other) { return upper_tail(std::abs(other - R) / sigma); };
    // The first period has none before it, the last none after it.
    const int k = static_cast<int>(y * f_h);
    double wrong = 0;
    if (k > 0) wrong += missed(strategy.R(y - 0.5 / f_h));
    if (k < f_h - 1) wrong += missed(strategy.R(y + 0.5 / f_h));
    sum += 1 - wrong;
  }
  return sum / places;
}

PatternLight brightest_light(const DesignGoal& goal) {
  require_valid(goal);
  const double clear = 3 * std::sqrt(goal.noise_variance);
  const double beta = goal.ambient;
  // alpha (beta_p + beta) + beta >= clear, and alpha_p + beta_p + 2 beta <= 255 - clear.
  const double beta_p = std::ceil(std::max(0.0, (clear - beta) / goal.alpha - beta));
  const double alpha_p = std::floor(std::min(255.0, 255 - clear - 2 * beta) - beta_p);
  const PatternLight light{.alpha_p = alpha_p, .beta_p = beta_p};
  if (!(light.alpha_p >= 1)) {
    throw Error(fmt::format(
        "no patterns keep a reflectivity of {} off zero under ambient light of {} and sigma_w^2 of "
        "{}; take a brighter surface or shade it",
        goal.alpha, goal.ambient, goal.noise_variance));
  }
  return light;
}

std::vector<Design> designs_by_frequency(const DesignGoal& goal) {
  const PatternLight light = brightest_light(goal);
  std::vector<Design> designs;
  for (int f_h = 2; f_h <= goal.most_periods; ++f_h) {
    if (const auto design = design_at(goal, light, f_h)) designs.push_back(*design);
  }
  return designs;
}

Design best_design(const DesignGoal& goal) {
  const std::vector<Design> designs = designs_by_frequency(goal);
  if (designs.empty()) {
    throw Error(
        fmt::format("no patterns of {} steps unwrap {} % of the pixels there; ask for less "
                    "or take more steps",
                    goal.steps, 100 * goal.success));
  }
  return *std::min_element(designs.begin(), designs.end(), [](const Design& a, const Design& b) {
    return a.coordinate_sigma < b.coordinate_sigma;
  });
}

}  // namespace slipstream
