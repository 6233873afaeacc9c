#pragma once

#include <functional>
#include <string>
#include <vector>

#include "app/live_session.h"
#include "app/output.h"
#include "slipstream/publish/publisher.h"

namespace slipstream::app {

/// Opens the sinks of these names for a session that has not begun; `document`: what `--json` would
/// say now, called from any thread. The session must live until the publisher is finished.
void open_sinks(const std::vector<std::string>& names, LiveSession& session,
                const std::function<nlohmann::json()>& document, Publisher& publisher);

/// `name`, `published` and `dropped` clouds and `error` of each.
nlohmann::json json_of(const std::vector<SinkStatistics>& sinks);

/// Says what the sinks have to say.
void tell_news(Publisher& publisher, Output& output);

}  // namespace slipstream::app
