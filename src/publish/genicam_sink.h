#pragma once

#include "publish/sink_kind.h"

namespace slipstream {

/// Acts as a GigE Vision and GenICam 3-D camera: one client at a time receives clouds as points or
/// depth, with intensity and confidence on request.
extern const SinkKind genicam_sink;

}  // namespace slipstream
