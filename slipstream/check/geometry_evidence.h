#pragma once

#include <cstddef>

#include "slipstream/check/frame_model.h"
#include "slipstream/check/scan_samples.h"

namespace slipstream {

/// What the samples say about frames and scanner.
struct GeometryEvidence {
  double without_point = 0;  ///< share whose ray meets its stripe nowhere in front of both devices
  double outside = 0;        ///< share of points where the projector sends no light
  double median_depth = 0;   ///< mm
  double out_of_range = 0;   ///< share of points outside of the calibrated depths, with a margin
  /// Median over the pixels of how much the coordinate changes from one pixel to the next, over how
  /// much it would on a surface that faces the camera: about 1 where all is right, negative where
  /// the stripes run the other way, near 0 where they run along the other axis. 1
  /// of a code alone.
  double slope = 1;
  double slope_doubt = 0;  ///< three standard errors of it, by how much the pixels scatter
};

/// Pictures that were turned over before they were saved.
struct PictureTurn {
  bool columns = false;  ///< the right side is on the left
  bool rows = false;     ///< the top is at the bottom
};

/// Lens distortion of the projector is left out: it moves points by less than what is asked here.
GeometryEvidence geometry_evidence(const FrameModel& model, const ScanSamples& samples,
                                   const Scanner& scanner, Axis axis, const FrameOrder& order,
                                   const PictureTurn& turn = {});

}  // namespace slipstream
