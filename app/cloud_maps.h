#pragma once

#include <cstdint>
#include <mutex>
#include <optional>

#include "app/live_session.h"
#include "slipstream/live/live_cloud.h"
#include "slipstream/reconstruct/engine.h"

namespace slipstream::app {

/// What the frames of a session's clouds say besides, as PublishedRun tells it; any sink may ask.
class CloudMaps {
 public:
  explicit CloudMaps(LiveSession& session) : session_(session) {}

  Image<std::uint8_t> phase(const LiveCloud& cloud);
  std::optional<Uncertainty> uncertainty(const LiveCloud& cloud);

 private:
  /// The frames whose maps are made then; none where they are not of what is looked for now.
  std::optional<FrameViews> measure(const LiveCloud& cloud);

  LiveSession& session_;
  std::mutex mutex_;
  std::optional<Engine> engine_;
  std::uint64_t changes_ = 0;
  int motion_ = 0;
  Maps maps_;
};

}  // namespace slipstream::app
