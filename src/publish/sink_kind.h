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

/// Serves a page with the newest cloud, its picture and the run's statistics over HTTP and
/// WebSocket; /statistics as JSON, /metrics for Prometheus, /health. If other machines can reach
/// it, a random token is required; the printed address contains it.
extern const SinkKind web_sink;

/// Answers the requests of controllers, JSON lines over TCP: scans on request.
extern const SinkKind tcp_sink;

/// Publishes clouds, pictures and services to ROS 2 over Cyclone DDS, in the domain ROS_DOMAIN_ID.
extern const SinkKind ros2_sink;

/// Acts as a GigE Vision and GenICam 3-D camera: one client at a time receives clouds as points or
/// depth, with intensity and confidence on request.
extern const SinkKind genicam_sink;

}  // namespace slipstream
