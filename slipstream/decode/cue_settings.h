#pragma once

#include <string_view>

#include "slipstream/codes/pattern_set.h"

namespace slipstream {

/// How the fringe order is found from a cue that shares the frames with the high frequency.
enum class CueRule {
  published,   ///< Liu 2010, Section 3.2: the cue's coordinate, solved for, names the nearest order
  likelihood,  ///< the order under which all channels of the pixel together are likeliest
  consensus,   ///< the likeliest order of the pixel and of its neighbours on the same surface
};

/// "published", "likelihood", "consensus".
std::string_view name_of(CueRule rule);

/// The rule of that name; throws Error for any other.
CueRule cue_rule_named(std::string_view name);

/// What a decoder must know, beside the frames, of a cue multiplexed into the patterns. Grey levels
/// are those of an 8-bit device, whatever the bits of the frames.
struct CueSettings {
  PatternLight light;           ///< of the patterns that were shown
  double ambient = 0;           ///< beta of Eq. (3.2); only a cue in the DC channel needs it
  double noise_variance = 1.6;  ///< sigma_w^2, > 0: how much the evidence of a pixel is worth
  CueRule rule = CueRule::consensus;
  double least_modulation = 0;  ///< B^c, >= 0: a darker pixel has no say in its neighbours' orders
};

/// Throws Error for settings outside their ranges.
void require_valid(const CueSettings& settings);

}  // namespace slipstream
