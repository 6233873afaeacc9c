#pragma once

#include <map>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "slipstream/pattern/pattern_set.h"
#include "slipstream/strategy/dual_frequency.h"
#include "slipstream/strategy/phase_channel_multiplexing.h"
#include "slipstream/strategy/phase_measuring.h"

namespace slipstream {

/// The registry: every pattern set that slipstream projects and decodes. A new one is added here.
using Strategy = std::variant<PhaseMeasuring, DualFrequency, PhaseChannelMultiplexing>;

/// Settings by the names that struct, scan.yaml and command line share.
using StrategySettings = std::map<std::string, double>;

/// A setting as the command line offers it.
struct SettingDescription {
  std::string name;
  std::string help;        ///< what it means, in a few words
  std::string strategies;  ///< which strategies have it: "pmp, dual-frequency"
};

/// Names of all strategies, in the order of the registry.
std::vector<std::string_view> strategy_names();

/// Every setting that some strategy has, once.
std::vector<SettingDescription> strategy_settings();

/// The strategy of that name with those settings, the others at their defaults. Throws Error for an
/// unknown name, a setting that this strategy does not have, or a value out of range.
Strategy make_strategy(std::string_view name, const StrategySettings& settings);

std::string_view name_of(const Strategy& strategy);

/// The settings that make_strategy needs to give the same strategy again.
StrategySettings settings_of(const Strategy& strategy);

/// Frames of one scan.
int frame_count(const Strategy& strategy);

/// N of each of its sinusoids, in the order of their frames.
std::vector<int> step_counts(const Strategy& strategy);

/// Whether the frames alone give the projector coordinate, and so a depth.
bool has_coordinate(const Strategy& strategy);

/// Most periods across the field that its patterns have.
double highest_frequency(const Strategy& strategy);

/// Throws Error when the highest frequency has less than two of the `length` projector pixels along
/// the axis for each period, so that no projector of that size can show it.
void require_resolved(const Strategy& strategy, int length);

/// Predicted variance of y (fields^2) at a pixel of that modulation (grey levels, as DecodedScan
/// tells it) under noise of sigma_w^2 (grey levels^2): what coordinate_variance of the strategy
/// says for the reflectivity that gives this modulation, Eqs. (3.6), (3.59).
double coordinate_variance(const Strategy& strategy, double modulation, double noise_variance);

/// What the projector shows.
PatternSet pattern_set(const Strategy& strategy, Axis axis, const PatternLight& light = {});

}  // namespace slipstream
