#pragma once

#include "app/live.h"

namespace slipstream::app {

/// One window from camera and projector to a cloud; the flags are its first choices. In builds with
/// SLIPSTREAM_VIEW.
void studio(const LiveFlags& flags, Output& output);

}  // namespace slipstream::app
