#pragma once

#include "slipstream/sequence.h"

// Along one axis, the frames of a scan cannot show that camera or projector moved since the
// calibration: the cloud is smooth and wrong. A guard is a few frames along the other axis, taken
// just after the scan, which can: see Scan::guard.
namespace slipstream {

/// The patterns of a scan's guard: one period for the fringe order and eight that measure, three
/// steps each. A pixel's coordinate errs by a fraction of a projector pixel, and the ripple of an
/// unknown gamma averages out over the picture.
Sequence guard_sequence(const Sequence& scan);

/// Whether a scan with these patterns can have a guard: it is along one axis, and the projector,
/// whose size is known, resolves the guard's patterns.
bool can_be_guarded(const Sequence& scan);

}  // namespace slipstream
