#pragma once

#include "slipstream/base/image.h"
#include "slipstream/frames/frame_views.h"

namespace slipstream {

/// Double three-step phase shifting: six frames of one sinusoid are two sets of three, a sixth of a
/// turn apart, whose phases are averaged. The error of Eq. (4.45) with N = 3 is odd in the sixth of
/// a turn, so its largest part cancels. What people do instead of correcting the phase; it costs
/// three frames. Wrapped phase of every pixel, rad, [0, 2 pi), from the 6 frames that start at
/// `first`.
Image<double> double_three_step_phase(const FrameViews& frames, int first);

}  // namespace slipstream
