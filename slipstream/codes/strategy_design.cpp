#include "slipstream/codes/strategy_design.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/multiplexing_design.h"
#include "slipstream/codes/predicted_variance.h"
#include "slipstream/codes/registry.h"
#include "slipstream/codes/unwrapping_chain.h"

namespace slipstream {
namespace {

double modulation_at(double alpha) {
  return alpha * PatternLight{}.alpha_p / 2;
}

/// Of so many frames, with at most so many periods: of every kind those worth asking.
std::vector<Strategy> candidates(int frames, int most_periods) {
  std::vector<Strategy> all{PhaseMeasuring{.steps = frames}};
  const auto add = [&](const auto& coding) {
    try {
      const Strategy strategy = coding;
      if (frame_count(strategy) == frames && highest_frequency(strategy) <= most_periods) {
        all.push_back(strategy);
      }
    } catch (const Error&) {  // there is none of so many frames
    }
  };
  add(DoubleThreeStep{});
  add(TwoPlusOne{});
  if (frames % 2 == 0) add(TwoFrequency2N{.steps = frames / 2});
  for (int high = 2; high <= most_periods; ++high) {
    const double f = high;
    add(PhaseChannelMultiplexing{.steps = frames, .high = f});
    add(PeriodCoded{.steps = frames, .high = f});
    add(DualFrequency{.steps = frames - 3, .low_steps = 3, .high = f});
    const double root = std::round(std::sqrt(f));
    if (root > 1) {
      const std::vector<int> steps{frames - 6, 3, 3};
      add(MultiFrequency{.steps = steps, .periods = {f, root, 1}});
      add(MultiFrequency{.steps = steps, .periods = {f, f - root, f - 2 * root + 1}});
    }
    for (int bits = 1; bits <= 10; ++bits) {
      add(GrayPhase{.steps = frames - bits, .periods = f});
    }
  }
  return all;
}

}  // namespace

void require_valid(const StrategyGoal& goal) {
  require_valid(DesignGoal{.alpha = goal.alpha,
                           .noise_variance = goal.noise_variance,
                           .success = goal.success,
                           .most_periods = goal.most_periods});
  if (goal.frames < 3 || goal.frames > 64) {
    throw Error(fmt::format("frames {} are out of range; 3 to 64", goal.frames));
  }
  if (!(goal.coordinate_sigma.value_or(1) > 0)) {
    throw Error(
        fmt::format("noise of the coordinate {} is out of range; above 0", *goal.coordinate_sigma));
  }
}

double predicted_success(const Layout& layout, double alpha, double noise_variance) {
  if (layout.unwrapping == Unwrapping::vote) {
    return predicted_unwrapping(layout, {}, alpha, 0, noise_variance);
  }
  const double deviations = modulation_at(alpha) / std::sqrt(noise_variance);
  double right = 1;
  for (const WrongOrder& order : wrong_orders(layout)) {
    right *= std::pow(1 - upper_tail(order.margin * deviations), order.count);
  }
  if (!layout.code) return right;
  // A bit is told from its reference, whose noise is less than its own.
  const double weakest = measuring_band(layout).share * deviations;
  const double wrong_bit = upper_tail(weakest / std::sqrt(2.0));
  return right * std::pow(1 - wrong_bit, static_cast<double>(layout.code->frames.size()));
}

std::vector<StrategyDesign> strategy_designs(const StrategyGoal& goal) {
  require_valid(goal);
  std::map<std::string, StrategyDesign> best;
  for (int frames = 3; frames <= goal.frames; ++frames) {
    for (const Strategy& strategy : candidates(frames, goal.most_periods)) {
      const Layout& layout = strategy.layout();
      const double B = measuring_band(layout).share * modulation_at(goal.alpha);
      const StrategyDesign design{
          .strategy = strategy,
          .success = predicted_success(layout, goal.alpha, goal.noise_variance),
          .coordinate_sigma = std::sqrt(coordinate_variance(layout, B, goal.noise_variance))};
      if (design.success < goal.success || !has_coordinate(layout)) continue;
      if (goal.coordinate_sigma && design.coordinate_sigma > *goal.coordinate_sigma) continue;
      const auto known = best.find(strategy.name());
      if (known == best.end()) {
        best.emplace(strategy.name(), design);
        continue;
      }
      const bool fewer = frame_count(known->second.strategy) == frames || !goal.coordinate_sigma;
      if (fewer && design.coordinate_sigma < known->second.coordinate_sigma) {
        known->second = design;
      }
    }
  }
  std::vector<StrategyDesign> designs;
  for (auto& [name, design] : best) designs.push_back(std::move(design));
  std::sort(designs.begin(), designs.end(), [&](const auto& a, const auto& b) {
    const int before = goal.coordinate_sigma ? frame_count(a.strategy) : 0;
    const int after = goal.coordinate_sigma ? frame_count(b.strategy) : 0;
    return std::pair(before, a.coordinate_sigma) < std::pair(after, b.coordinate_sigma);
  });
  return designs;
}

}  // namespace slipstream
