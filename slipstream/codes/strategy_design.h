#pragma once

#include <optional>
#include <vector>

#include "slipstream/codes/strategy.h"

namespace slipstream {

/// What strategies of any kind are chosen by.
struct StrategyGoal {
  int frames = 10;                           ///< of a scan at most, 3 to 64
  std::optional<double> coordinate_sigma{};  ///< of y, fields: enough; else as little as there is
  double alpha = 0.5;                        ///< the least reflectivity to be measured, (0, 1]
  double noise_variance = 1.6;               ///< sigma_w^2, grey levels^2
  double success = 0.999;                    ///< share of right fringe orders, [0.5, 1)
  int most_periods = 64;                     ///< that projector and lenses show, 2 to 1000
};

/// A strategy and what it promises at the goal's light.
struct StrategyDesign {
  Strategy strategy{};
  double success = 1;           ///< share of right fringe orders, each pixel by itself
  double coordinate_sigma = 0;  ///< standard deviation of y, fields
};

/// Throws Error for a goal outside its ranges.
void require_valid(const StrategyGoal& goal);

/// Share of the pixels whose fringe order noise leaves right: of a layout that votes as
/// predicted_unwrapping; else by wrong_orders, where C and S of each band have noise alike, and by
/// the bits of a code.
double predicted_success(const Layout& layout, double alpha, double noise_variance);

/// Of each kind the one of the registry that meets the goal with least noise; where a noise is
/// wanted the one of fewest frames that reaches it. Of least noise, or fewest frames, first.
std::vector<StrategyDesign> strategy_designs(const StrategyGoal& goal);

}  // namespace slipstream
