#pragma once

#include "slipstream/codes/sequence.h"

namespace slipstream {

/// What patterns are to be designed for.
struct DesignGoal {
  int steps = 5;                ///< N, 3 to 64
  double alpha = 0.5;           ///< the least reflectivity that is to be measured, (0, 1]
  double ambient = 0;           ///< beta, grey levels of 255
  double noise_variance = 1.6;  ///< sigma_w^2, grey levels^2
  /// Share of the pixels unwrapped rightly each by itself, without neighbours: [0.5, 1).
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

/// Share of the pixels, evenly over the field, whose cue names the right period; of a layout that
/// votes: noise of the cue, Eqs. (3.67), (3.76), (3.101), against half a period.
double predicted_unwrapping(const Layout& layout, const PatternLight& light, double alpha,
                            double ambient, double noise_variance);

/// The brightest patterns that stay three standard deviations of the noise off zero at the goal's
/// alpha, Eq. (3.7), and off full scale at alpha = 1. Throws Error if there are none.
PatternLight brightest_light(const DesignGoal& goal);

/// For each f_h from 2 to most_periods that can meet the goal: the c_1 of least noise, in
/// hundredths.
std::vector<Design> designs_by_frequency(const DesignGoal& goal);

/// The one of least noise among them. Throws Error where none meets the goal.
Design best_design(const DesignGoal& goal);

/// Why these patterns are unwise: fewer than four projector pixels a period leave little
/// modulation, or the cue is too weak for the surface, light and noise of a default DesignGoal.
/// Empty if OK.
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

/// Share of the pixels whose fringe order noise leaves right: predicted_unwrapping of a layout that
/// votes; else by wrong_orders, with equal noise in C and S of each band, and by a code's bits.
double predicted_success(const Layout& layout, double alpha, double noise_variance);

/// Of each kind the strategy that meets the goal with least noise or, for a given noise, with
/// fewest frames; best first.
std::vector<StrategyDesign> strategy_designs(const StrategyGoal& goal);

}  // namespace slipstream
