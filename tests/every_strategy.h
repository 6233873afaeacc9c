// Every coding of the registry, with settings that lead through all of its ways.
#pragma once

#include <string>
#include <vector>

#include "slipstream/gray_code.h"
#include "slipstream/strategy.h"

namespace slipstream {

/// Those whose frames say where every pixel is to a part of a period.
inline std::vector<Strategy> every_phase_strategy() {
  const Shifts elsewhere{.origin = 2.1, .backwards = true};
  return {PhaseMeasuring{.steps = 4, .shifts = elsewhere},
          DualFrequency{.steps = 3, .low_steps = 5, .high = 12, .shifts = elsewhere},
          MultiFrequency{},
          MultiFrequency{.steps = {6, 3, 4}, .periods = {1, 5, 16}, .shifts = {-1, false}},
          MultiFrequency{.steps = {3}, .periods = {25, 20, 22}, .unwrapping = "heterodyne"},
          MultiFrequency{.steps = {4, 3, 3}, .periods = {9.6, 11.3, 10.5}, .shifts = elsewhere},
          GrayPhase{},
          GrayPhase{.steps = 3, .periods = 20, .complementary = false, .shifts = elsewhere},
          GrayPhase{.steps = 5, .periods = 12, .reference = "inverse"},
          GrayPhase{.periods = 12, .stripes = 100, .reference = "inverse"},
          GrayPhase{.periods = 16, .reference = "white-black"},
          GrayPhase{.periods = 8, .reference = "none"},
          TwoPlusOne{},
          TwoPlusOne{.shifts = elsewhere},
          FastThreeStep{},
          DoubleThreeStep{.shifts = elsewhere},
          TwoFrequency2N{},
          TwoFrequency4N{.periods = {1, 4, 16}, .shifts = elsewhere}};
}

/// Those of them that the shaders leave to the CPU.
inline std::vector<Strategy> every_strategy_on_cpu() {
  const Shifts elsewhere{.origin = 2.1, .backwards = true};
  return {MicroPhaseShifting{.periods = {25, 23, 22, 19}, .shifts = elsewhere},
          MultiFrequency{.steps = {3}, .periods = {13, 15}, .unwrapping = "number-theory"},
          ModulatedPhaseShifting{}, ModulatedPhaseShifting{.carrier_steps = 2, .carrier = 40},
          ModulatedPhaseShifting{
              .steps = 4, .carrier_steps = 3, .periods = {1, 5, 20}, .shifts = elsewhere}};
}

/// Those of them with a cue in the same frames, whose fringe orders the neighbours confirm.
inline std::vector<Strategy> every_strategy_with_cue() {
  const Shifts elsewhere{.origin = 2.1, .backwards = true};
  return {PhaseChannelMultiplexing{.steps = 5, .shifts = {0.7, true}}, PeriodCoded{},
          PeriodCoded{.steps = 6, .high = 16, .shifts = elsewhere}};
}

/// Those that say it to a stripe.
inline std::vector<Strategy> every_code() {
  return {GrayCode{.bits = 9},
          GrayCode{.bits = 9, .reference = "inverse", .stripes = 400, .least_first = true},
          GrayCode{.bits = 7, .reference = "none", .plain = true}, ExclusiveOrGray{.bits = 9},
          ExclusiveOrGray{.bits = 8, .base = 2, .reference = "white-black"}};
}

inline std::vector<Strategy> every_strategy() {
  std::vector<Strategy> all = every_phase_strategy();
  for (const auto& more : {every_strategy_on_cpu(), every_strategy_with_cue(), every_code()}) {
    all.insert(all.end(), more.begin(), more.end());
  }
  return all;
}

}  // namespace slipstream
