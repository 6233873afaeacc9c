#pragma once

#include "slipstream/reconstruct/epipolar_tables.h"
#include "slipstream/reconstruct/phase_matcher.h"

namespace slipstream {

/// Finds the depths of a scene, and the origin of its phase, from a single band of many periods
/// seen by two cameras. The orders of a large connected surface are known up to one number, so that
/// all its pixels decide together which one fits: for the right one, the second camera sees nearly
/// all of them under the same phase. First with the origin as given; if most of the light fits
/// nowhere, with every other. nullopt if most of it still fits nowhere, or orders of several depths
/// fit it.
///
/// `tables`: of the first camera beside the second. `phase`: of the first, rad, [0, 2 pi), NaN
/// where invalid. `set`: depths beyond these are not tried.
std::optional<CameraAgreement> camera_agreement(const EpipolarTables& tables, double periods,
                                                const DepthRange& set, const Image<float>& phase,
                                                const CameraPhases& first,
                                                const CameraPhases& second);

}  // namespace slipstream
