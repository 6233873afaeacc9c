#pragma once

#include "publish/sink_kind.h"

namespace slipstream {

/// Serves a page with the newest cloud, its picture and the run's statistics over HTTP and
/// WebSocket; /statistics as JSON, /metrics for Prometheus, /health. If other machines can reach
/// it, a random token is required; the printed address contains it.
extern const SinkKind web_sink;

}  // namespace slipstream
