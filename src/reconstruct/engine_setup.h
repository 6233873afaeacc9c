#pragma once

#include <string_view>

#include "decode/cue_evidence.h"
#include "decode/phase_decoder.h"
#include "response/correction.h"
#include "slipstream/engine.h"
#include "slipstream/frame_set.h"

// Figures that engines derive from their setup.
namespace slipstream {

/// Throws Error unless the frames have the camera's size.
void require_size(const FrameViews& frames, Size camera);

/// Whether the depth range gives the fringe order: both ends are set, and frames alone do not.
bool unwraps_by_depth(const EngineSetup& setup);

/// Whether the fringe order comes from the whole image: from the depth range or from surfaces.
bool unwraps_by_picture(const EngineSetup& setup);

/// Inputs of a cue in addition to the frames: light of patterns and room, noise, the rule.
CueSettings cue_settings(const EngineSetup& setup);

/// Correction of each band's phase for the scanner's response; empty if the response is unknown.
PhaseCorrections phase_corrections(const EngineSetup& setup);

/// Projector pixels along the axis of the patterns.
int projector_length(const EngineSetup& setup);

/// Least modulation of a point, grey levels of 255: as set, or more if noise would hide the fringe
/// order, see CueEvidence::least_modulation.
double least_modulation(const EngineSetup& setup);

/// Raises the settings' least modulation to this; the same pixels vote as before.
void raise_least_modulation(EngineSetup& setup);

/// Modulation threshold, grey levels of frames whose largest is `full_scale`.
double least_modulation(const ReconstructSettings& settings, double full_scale);

/// Modulation from which a pixel votes on its neighbours' orders, in the same grey levels.
double least_neighbour_modulation(const ReconstructSettings& settings, double full_scale);

}  // namespace slipstream
