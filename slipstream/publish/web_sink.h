#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "slipstream/publish/cloud_sink.h"

namespace slipstream {

/// Where a page is served.
struct WebAddress {
  std::string host = "127.0.0.1";  ///< as a number
  std::uint16_t port = 0;          ///< 0: one that is free
  bool loopback = true;            ///< nobody but this machine reaches it
};

/// From "PORT" or "ADDRESS:PORT", as "8080", "0.0.0.0:8080", "[::1]:8080". Throws Error for others.
WebAddress web_address_from(const std::string& where);

/// Serves a page with the newest cloud, its picture and the run's statistics, over HTTP and
/// WebSocket; /statistics as JSON, /metrics as Prometheus reads it, /health. Where other machines
/// reach it, those who know a random token are answered, which the news tell as part of the page's
/// address. Clients get a cloud when they ask for one. Throws WorldError where the port cannot be
/// had.
std::unique_ptr<CloudSink> open_web_sink(const std::string& where, PublishedRun run);

}  // namespace slipstream
