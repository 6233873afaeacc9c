#pragma once

#include <optional>
#include <string>
#include <vector>

#include "slipstream/codes/pattern_set.h"
#include "slipstream/codes/phase_channel_multiplexing.h"
#include "slipstream/codes/sequence.h"
#include "slipstream/codes/strategy.h"

namespace slipstream {

/// What patterns are to be designed for.
struct DesignGoal {
  int steps = 5;                ///< N, 3 to 64
  double alpha = 0.5;           ///< the least reflectivity that is to be measured, (0, 1]
  double ambient = 0;           ///< beta, grey levels of 255
  double noise_variance = 1.6;  ///< sigma_w^2, grey levels^2
  /// Share of the pixels that are to be unwrapped rightly each by itself, before their neighbours
  /// are asked: [0.5, 1).
  double success = 0.99;
  int most_periods = 64;  ///< largest f_h to be considered, 2 to 1000
};

/// Patterns for a goal and what is to be expected of them.
struct Design {
  PhaseChannelMultiplexing strategy;
  PatternLight light;
  double success = 0;           ///< predicted, of the pixels each by itself
  double coordinate_sigma = 0;  ///< standard deviation of y at the goal's alpha, (3.63), fields
};

/// Throws Error for a goal outside its ranges.
void require_valid(const DesignGoal& goal);

/// Probability that a standard normal number is above x.
double upper_tail(double x);

/// Share of the pixels, evenly over the field, whose cue names the right period: from the noise of
/// the cue, Eqs. (3.67), (3.76), (3.101), against half a period. Of a layout that votes.
double predicted_unwrapping(const Layout& layout, const PatternLight& light, double alpha,
                            double ambient, double noise_variance);

/// The brightest patterns whose frames stay three standard deviations of the noise off zero at the
/// goal's alpha, Eq. (3.7), and off the largest grey level at alpha = 1. Throws Error where there
/// are none.
PatternLight brightest_light(const DesignGoal& goal);

/// For each f_h from 2 to most_periods the share c_1 of the least noise that meets the goal, in
/// hundredths; an f_h at which none does is left out.
std::vector<Design> designs_by_frequency(const DesignGoal& goal);

/// The one of least noise among them. Throws Error where none meets the goal.
Design best_design(const DesignGoal& goal);

/// Why it is unwise to show patterns that can be shown: fewer than four projector pixels a period
/// leave little of the modulation, or their cue is too weak for their periods
/// where surface, light and noise are as a DesignGoal has them at first. Empty where it is not.
std::string doubt_about(const Sequence& sequence);

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
