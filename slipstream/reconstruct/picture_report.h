#pragma once

#include "slipstream/cloud/cloud.h"
#include "slipstream/decode/maps.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/reconstruct/engine.h"

namespace slipstream {

/// What the frames of a scan say about its light, with or without a scanner.
struct PictureReport {
  Image<Validity> validity{};  ///< too_dark, saturated, else valid
  double modulation = 0;       ///< median of the valid pixels, grey levels of 255; 0 without any
};

/// By the maps of these frames, which are merged where there are several exposures: Engine::merged.
PictureReport picture_report(const FrameViews& frames, const Maps& maps,
                             const ReconstructSettings& settings);

/// The projector coordinate of the pixels that are lit, not saturated and of a fringe order that
/// their neighbours confirm, NaN elsewhere; with or without a scanner.
Image<double> measured_coordinates(Engine& engine, const FrameViews& frames);

}  // namespace slipstream
