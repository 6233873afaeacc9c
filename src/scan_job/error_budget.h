#pragma once

#include "slipstream/scan_job.h"

namespace slipstream {

/// The error budget of a result by one camera and the projector, with maps and uncertainty;
/// `frames`: of its scan. Also sets the uncertainty's systematic part.
ErrorBudget error_budget(ScanResult& result, const FrameViews& frames);

}  // namespace slipstream
