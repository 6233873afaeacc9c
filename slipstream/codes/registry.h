#pragma once

#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "slipstream/codes/gray_code.h"
#include "slipstream/codes/one_frame.h"
#include "slipstream/codes/phase_channel_multiplexing.h"
#include "slipstream/codes/phase_shifting.h"
#include "slipstream/codes/strategy.h"

namespace slipstream {

/// The registry: every coding that can be asked for by its name. A new one is added here.
using KnownCodings =
    std::variant<PhaseMeasuring, DualFrequency, PhaseChannelMultiplexing, MultiFrequency, GrayCode,
                 GrayPhase, ExclusiveOrGray, TwoPlusOne, FastThreeStep, DoubleThreeStep,
                 TwoFrequency2N, TwoFrequency4N, MicroPhaseShifting, ModulatedPhaseShifting,
                 PeriodCoded, FourierProfilometry, CompositePattern, DeBruijn, SymbolArray>;

/// What is shown where nobody says what.
Strategy default_strategy();

/// What people show most, for a choice; all of it gives a projector coordinate.
std::vector<Strategy> usual_strategies();

/// Name and settings in a line: "dual-frequency, high 16, low 1, steps 3".
std::string label_of(const Strategy& strategy);

/// The strategy of such a line; settings that it does not name are at their defaults. Throws Error
/// as make_strategy, and for a setting without a value.
Strategy strategy_labelled(std::string_view label);

/// One of each kind and size that is worth knowing apart, of the fewest frames first.
std::vector<Strategy> strategies_to_compare();

/// A setting as the command line offers it.
struct SettingDescription {
  std::string name;
  std::string help;        ///< what it means, in a few words
  std::string strategies;  ///< which have it, with its default: "pmp 4, dual-frequency 3"
  bool is_switch = false;  ///< on or off
  bool is_word = false;    ///< else a number, or numbers with commas between
};

/// Names of all strategies, in the order of the registry.
std::vector<std::string_view> strategy_names();

/// Names of those whose frames give a projector coordinate with the settings that they have by
/// default.
std::vector<std::string_view> names_with_coordinate();

/// Every setting that some strategy has, once.
std::vector<SettingDescription> strategy_settings();

/// The strategy of that name with those settings, the others at their defaults. Throws Error for an
/// unknown name, a setting that this strategy does not have, or a value out of range.
Strategy make_strategy(std::string_view name, const StrategySettings& settings);

}  // namespace slipstream
