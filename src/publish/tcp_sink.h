#pragma once

#include "publish/sink_kind.h"

namespace slipstream {

/// Answers the requests of controllers, JSON lines over TCP: scans on request.
extern const SinkKind tcp_sink;

}  // namespace slipstream
