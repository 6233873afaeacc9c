#pragma once

#include <memory>
#include <string>

#include "slipstream/publish/cloud_sink.h"

namespace slipstream {

/// What can be asked for: "web:[ADDRESS:]PORT, mcap:FILE, ros2:NAMESPACE, genicam:ADDRESS".
std::string sink_forms();

/// Throws Error, which names the forms, for what is none of them.
void require_sink(const std::string& name);

/// Throws as require_sink, and WorldError for a port that is taken or a file that cannot be
/// written.
std::unique_ptr<CloudSink> open_sink(const std::string& name, PublishedRun run);

/// One kind of sink: a file that defines one of these.
struct SinkKind {
  const char* name;
  const char* form;                          ///< "NAME:WHAT"
  void (*require)(const std::string& what);  ///< throws Error where that cannot be meant
  std::unique_ptr<CloudSink> (*open)(const std::string& what, PublishedRun run);
};

/// Serves a page with the newest cloud, its picture and the run's statistics over HTTP and
/// WebSocket; /statistics as JSON, /metrics as Prometheus reads it, /health. Where other machines
/// reach it, those who know a random token are answered, which the news tell as part of the page's
/// address. Clients get a cloud when they ask for one.
extern const SinkKind web_sink;
/// Writes clouds and pictures as messages of ROS 2 into an MCAP file: /points and /image, of clouds
/// that share no frame.
extern const SinkKind mcap_sink;
/// Clouds, pictures and services of ROS 2 over Cyclone DDS, in the domain of ROS_DOMAIN_ID.
extern const SinkKind ros2_sink;
/// Is a 3-D camera to whoever reads GigE Vision and GenICam: one client at a time gets clouds, as
/// points or depth, with intensity and confidence where it asks for these.
extern const SinkKind genicam_sink;

}  // namespace slipstream
