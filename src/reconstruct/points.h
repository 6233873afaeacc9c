#pragma once

#include "geometry/triangulator.h"
#include "slipstream/engine.h"

namespace slipstream {

/// Why each pixel is rejected, or `valid`: too dark, saturated, a fringe order that the neighbours
/// do not confirm, or the reason in `order` unless that is empty.
Image<Validity> judged(const BasicMaps<double>& maps, const Image<Validity>& order,
                       const FrameViews& frames, const EngineSetup& setup);

/// Projector coordinate of a point in the camera's frame, mm; NaN behind the projector.
double coordinate_of(const Eigen::Vector3d& point, const EngineSetup& setup);

/// Why a point at this projector coordinate is rejected, or `valid`: behind the camera or the
/// projector, outside the projector's field or outside the depth range. `point`: camera's frame,
/// mm.
Validity validity_of(double coordinate, const Eigen::Vector3d& point, const EngineSetup& setup);

/// Points of the valid pixels, without intensity. Rejects points behind the camera or the
/// projector, outside the projector's field or outside the depth range.
BasicCloud<double> triangulated(const Image<double>& coordinates, Image<Validity> validity,
                                const Triangulator& triangulate, const EngineSetup& setup);

/// See Engine::uncertainty. `full_scale`: largest grey level of the frames.
Uncertainty uncertainty_of(const Cloud& cloud, const Maps& maps, const EngineSetup& setup,
                           double full_scale);

}  // namespace slipstream
