#pragma once

#include <memory>
#include <string>

#include "slipstream/cloud_sink.h"

namespace slipstream {

/// One kind of sink; each is defined in its own file.
struct SinkKind {
  const char* name;
  const char* form;                          ///< "NAME:WHAT"
  void (*require)(const std::string& what);  ///< throws Error if invalid
  std::unique_ptr<CloudSink> (*open)(const std::string& what, PublishedRun run);
};

}  // namespace slipstream
