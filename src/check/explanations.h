#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "check/fit.h"
#include "check/judged_scan.h"
#include "slipstream/check.h"
#include "slipstream/finding.h"

namespace slipstream {

/// Checks that frames, sequence and scanner fit together. If they do not, names the common mistake
/// that explains it best: wrong frame order, number of periods or axis, an uncorrected response,
/// flicker, flipped pictures, or a scanner file that is inverted, for another picture size or of
/// another rig. `fit`: the result of fit_of.
ScanFindings explain(const JudgedScan& scan, const Fit& fit);

/// The symptom of a geometry that does not fit, without a cause. `measured`: "frames" or "map".
Finding geometry_mismatch(const GeometryEvidence& geometry, std::string_view measured);

/// The symptom of depths that do not fit, without a cause.
Finding depths_beyond_boards(const GeometryEvidence& geometry);

/// The harmless cause of such depths: a scene nearer or farther than the boards.
Cause beyond_the_boards();

}  // namespace slipstream
