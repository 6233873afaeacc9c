#pragma once

#include "geometry/stripe_geometry.h"
#include "reconstruct/fused/point_rows.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// Coordinates to points of this geometry; those outside `depths` are out of range.
PointStage point_stage(const StripeGeometry& geometry, const DepthRange& depths);

}  // namespace slipstream
