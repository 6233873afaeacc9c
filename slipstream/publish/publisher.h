#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "slipstream/publish/cloud_sink.h"

namespace slipstream {

/// What has become of the clouds that a sink was given.
struct SinkStatistics {
  std::string name;             ///< as it was asked for
  std::uint64_t published = 0;  ///< that it has taken
  std::uint64_t dropped = 0;    ///< that it had no time for, the oldest of those that waited
  std::string error;            ///< why it takes no more; empty where it does
};

/// Gives clouds to sinks, each on a thread of its own behind a queue that drops its oldest: nobody
/// waits for any of them.
class Publisher {
 public:
  /// Clouds that wait for a sink, and all that it may hold.
  static constexpr std::size_t waiting_clouds = 4, held_clouds = waiting_clouds + 2;

  Publisher();
  ~Publisher();  ///< finishes
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  /// Before the first cloud.
  void add(const std::string& name, std::unique_ptr<CloudSink> sink);
  void publish(const Pooled<LiveCloud>& cloud);
  /// Publishes what waits, and ends the sinks: they call nothing of their run any more.
  void finish();

  /// In the order in which they were added.
  [[nodiscard]] std::vector<SinkStatistics> statistics() const;
  /// What people should know and was not told before: to `say` what sinks tell, to `warn` that one
  /// drops clouds or has failed, each once. One thread asks.
  void tell(const std::function<void(const std::string&)>& say,
            const std::function<void(const std::string&)>& warn);

 private:
  struct Outlet;
  std::vector<std::unique_ptr<Outlet>> outlets_;
};

}  // namespace slipstream
