#pragma once

#include <limits>
#include <optional>

#include "slipstream/geometry/scanner.h"
#include "slipstream/phase/fringe_order_consensus.h"
#include "slipstream/phase/phase_correction.h"
#include "slipstream/phase/phase_decoder.h"
#include "slipstream/strategy/strategy.h"

namespace slipstream {

/// What decides whether a pixel becomes a point, and how it is computed.
struct ReconstructSettings {
  Backend backend = Backend::lut;
  /// Least modulation B^c, grey levels of the frames; by default 15 of an 8-bit camera's 255 and as
  /// much of another's full scale.
  std::optional<double> minimum_modulation;
  /// A pixel with a saturated frame is dropped (`false` keeps it, biased).
  bool drop_saturated = true;
  /// When the fringe order of a strategy with several frequencies is believed.
  FringeOrderConsensus fringe_order;
  /// Of a strategy whose fringe order comes from a cue in the same frames: the light of its
  /// patterns and of the room, and the rule by which it is unwrapped.
  CueSettings cue;
  /// How far past the ends of the projector's field, as a share of its length across the stripes, a
  /// point may lie.
  double field_margin = 0.02;
  /// What is added to each sinusoid's phase, by its N, so that the projector's response does not
  /// show; none where empty. Costs no time where phase is looked up, and little in the fused pass.
  PhaseCorrections phase_corrections;
  double nearest = 0;                                         ///< mm, least depth
  double farthest = std::numeric_limits<double>::infinity();  ///< mm, largest depth
};

/// Throws Error where the scanner or the settings are not valid or see no depth along that axis, or
/// where the strategy's settings are out of range, too fine for the projector, or its frames give
/// no projector coordinate.
void require_reconstructible(const Scanner& scanner, const Strategy& strategy, Axis axis,
                             const ReconstructSettings& settings);

/// The modulation threshold, grey levels of frames whose largest is `full_scale`.
double least_modulation(const ReconstructSettings& settings, double full_scale);

}  // namespace slipstream
