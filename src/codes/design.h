#pragma once

#include <optional>
#include <string>
#include <vector>

#include "slipstream/sequence.h"

namespace slipstream {

struct DesignGoal {
  int steps = 5;                ///< N, 3 to 64
  double alpha = 0.5;           ///< least reflectivity to measure, (0, 1]
  double ambient = 0;           ///< beta, grey levels of 255
  double noise_variance = 1.6;  ///< sigma_w^2, grey levels^2
  /// Share of pixels to unwrap correctly on their own, without neighbours: [0.5, 1).
  double success = 0.99;
  int most_periods = 64;  ///< largest f_h considered, 2 to 1000
};

/// Patterns designed for a goal, with their predicted quality.
struct Design {
  PhaseChannelMultiplexing strategy;
  PatternLight light;
  double success = 0;           ///< predicted share of pixels unwrapped correctly on their own
  double coordinate_sigma = 0;  ///< standard deviation of y at the goal's alpha, (3.63), fields
};

/// Throws Error if a value of the goal is out of range.
void require_valid(const DesignGoal& goal);

/// Predicted share of pixels, uniform over the field, whose cue gives the correct period: cue
/// noise, Eqs. (3.67), (3.76), (3.101), against half a period. Requires a layout that votes.
double predicted_unwrapping(const Layout& layout, const PatternLight& light, double alpha,
                            double ambient, double noise_variance);

/// The brightest patterns that stay three standard deviations of the noise above zero at the goal's
/// alpha, Eq. (3.7), and below full scale at alpha = 1. Throws Error if there are none.
PatternLight brightest_light(const DesignGoal& goal);

/// For each f_h from 2 to most_periods that can meet the goal, the design whose c_1, in hundredths,
/// gives the least noise.
std::vector<Design> designs_by_frequency(const DesignGoal& goal);

/// The design with the least noise. Throws Error if none meets the goal.
Design best_design(const DesignGoal& goal);

/// Warning if these patterns are unwise: fewer than four projector pixels a period leave little
/// modulation, or the cue is too weak for the surface, light and noise of a default DesignGoal.
/// Otherwise empty.
std::string doubt_about(const Sequence& sequence);

/// Requirements for choosing a strategy of any kind.
struct StrategyGoal {
  int frames = 10;                           ///< most frames of a scan, 3 to 64
  std::optional<double> coordinate_sigma{};  ///< sufficient for y, fields; default: least possible
  double alpha = 0.5;                        ///< least reflectivity to measure, (0, 1]
  double noise_variance = 1.6;               ///< sigma_w^2, grey levels^2
  double success = 0.999;                    ///< share of correct fringe orders, [0.5, 1)
  int most_periods = 64;                     ///< most that projector and lenses resolve, 2 to 1000
};

/// A strategy and its predicted quality for a goal.
struct StrategyDesign {
  Strategy strategy{};
  double success = 1;           ///< share of correct fringe orders, each pixel on its own
  double coordinate_sigma = 0;  ///< standard deviation of y, fields
};

/// Throws Error if a value of the goal is out of range.
void require_valid(const StrategyGoal& goal);

/// Predicted share of pixels with a correct fringe order: predicted_unwrapping if the layout votes;
/// otherwise from wrong_orders, with equal noise in C and S of each band, and from a code's bits.
double predicted_success(const Layout& layout, double alpha, double noise_variance);

/// For each kind of strategy, the settings that meet the goal with the least noise or, if the noise
/// is given, with the fewest frames; best first.
std::vector<StrategyDesign> strategy_designs(const StrategyGoal& goal);

}  // namespace slipstream
