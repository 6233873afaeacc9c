#pragma once

#include <memory>
#include <string>

#include "slipstream/publish/cloud_sink.h"

namespace slipstream {

/// Throws Error where the file's ending is not .mcap.
void require_mcap_file(const std::string& path);

/// Writes clouds and pictures as messages of ROS 2 into an MCAP file: /points and /image, of clouds
/// that share no frame. Throws as require_mcap_file, and WorldError
/// where it cannot be written.
std::unique_ptr<CloudSink> open_mcap_sink(const std::string& path, PublishedRun run);

}  // namespace slipstream
