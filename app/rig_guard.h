#pragma once

#include <optional>

#include "app/monitor_projector.h"
#include "slipstream/named_source.h"
#include "slipstream/scan_job.h"

namespace slipstream::app {

/// Compares a checked scan with its guard and prints how well they meet. A guard that cannot be
/// compared is a warning: the scan may be read with other settings.
GuardResult compared_with_guard(const Scan& scan, const ReconstructSettings& settings,
                                Output& output);

/// Before `live` shows patterns on a monitor: takes one scan and its guard, if these patterns can
/// have one, and warns of a rig that has moved since its calibration. Says so if nothing is
/// compared, because the scene does not stand still. `opened`: not started, and stopped again.
void check_rig(const MonitorProjector& projector, bool triggered, const EngineSetup& setup,
               const NamedSource& opened, Output& output);

}  // namespace slipstream::app
