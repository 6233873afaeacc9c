#pragma once

#include <memory>
#include <string>

#include "slipstream/publish/cloud_sink.h"

namespace slipstream {

/// What can be asked for: "web:[ADDRESS:]PORT, mcap:FILE".
std::string sink_forms();

/// Throws Error, which names the forms, for what is none of them.
void require_sink(const std::string& name);

/// Throws as require_sink, and WorldError for a port that is taken or a file that cannot be
/// written.
std::unique_ptr<CloudSink> open_sink(const std::string& name, PublishedRun run);

}  // namespace slipstream
