#pragma once

#include "slipstream/codes/sequence.h"
#include "slipstream/frames/pool.h"
#include "slipstream/geometry/scanner.h"
#include "slipstream/live/live_cloud.h"

namespace slipstream {

/// Something of a run that can be changed while it goes on, as it is now.
struct RunSetting {
  std::string name;                    ///< as the flag of `slipstream live`: "min-modulation"
  std::string help;                    ///< what it means, in a few words
  std::string unit{};                  ///< of a number: "ms"; empty where it has none
  std::string value{};                 ///< a number, or one of the choices
  std::vector<std::string> choices{};  ///< "off" and "on" of a switch; empty for a number
  double least = 0, most = 0;          ///< of a number
  std::string state{};                 ///< what is to be said beside it; mostly empty
};

/// Throws Error, which says what would be right, unless a setting of that name takes that value.
void require_settable(const std::vector<RunSetting>& settings, const std::string& name,
                      const std::string& value);

/// The run whose clouds are published. The functions are called from any thread; they may throw.
struct PublishedRun {
  Lens camera{};           ///< whose pixels the clouds have
  std::string scanner{};   ///< the text of its scanner file; empty where none is known
  bool has_points = true;  ///< whether a scanner is known; else there are pictures alone
  std::function<std::string()> statistics{};  ///< what the run has counted until now, as JSON
  std::function<std::string()> trouble{};     ///< one line; empty where all is well
  /// Writes the newest cloud; returns where. Throws Error within a second of the last time.
  std::function<std::string()> save{};
  /// The phase that the cloud's frames show: of each pixel 1 to 255 over a period, 0 where it is
  /// too dark. Empty where they are not of what is looked for now. One thread at a time.
  std::function<Image<std::uint8_t>(const LiveCloud&)> phase{};
  /// What the frames show now.
  std::function<Sequence()> sequence{};
  /// Null if the noise is unknown; nullopt for frames of another sequence. One thread at a time.
  std::function<std::optional<Uncertainty>(const LiveCloud&)> uncertainty{};
  /// What can be changed now, in a stable order, by any sink or the viewer; none of a lost camera.
  std::function<std::vector<RunSetting>()> settings{};
  /// Sets the one of that name to a value that it can have: throws Error as require_settable.
  std::function<void(const std::string& name, const std::string& value)> change{};
};

/// Where clouds go: a file, other programs, a browser. A Publisher gives each its thread.
class CloudSink {
 public:
  virtual ~CloudSink() = default;

  /// Whether the sink is to be given this cloud, of those that come. In the thread that makes them.
  [[nodiscard]] virtual bool wants(const LiveCloud&) { return true; }
  /// Takes the next cloud; may keep one at most. What is thrown ends the sink and nothing else.
  /// `alone`: others wait and some were dropped: add nothing slow, as uncertainty or frames.
  virtual void put(const Pooled<LiveCloud>& cloud, bool alone) = 0;
  /// No more clouds come. Throws likewise.
  virtual void finish() {}
  /// Lines for people that were not told before. From any thread.
  virtual std::vector<std::string> news() { return {}; }
};

/// A sink of clouds that share no frame with the one before.
class DisjointCloudSink : public CloudSink {
 public:
  [[nodiscard]] bool wants(const LiveCloud& cloud) final {
    const std::uint64_t newest = cloud.newest.sequence, frames = cloud.frames.size();
    const bool wanted = !last_ || newest < *last_ || newest - *last_ >= frames;
    if (wanted) last_ = newest;
    return wanted;
  }

 private:
  std::optional<std::uint64_t> last_;  ///< sequence of the newest frame of the one chosen last
};

/// What can be asked for: "web:[ADDRESS:]PORT, mcap:FILE, ros2:NAMESPACE, genicam:ADDRESS".
std::string sink_forms();

/// Throws Error, which names the forms, for what is none of them.
void require_sink(const std::string& name);

/// Throws as require_sink, and WorldError if the port is taken or the file cannot be written.
std::unique_ptr<CloudSink> open_sink(const std::string& name, PublishedRun run);

/// One kind of sink: a file that defines one of these.
struct SinkKind {
  const char* name;
  const char* form;                          ///< "NAME:WHAT"
  void (*require)(const std::string& what);  ///< throws Error where that cannot be meant
  std::unique_ptr<CloudSink> (*open)(const std::string& what, PublishedRun run);
};

/// Serves a page with the newest cloud, its picture and the run's statistics over HTTP and
/// WebSocket; /statistics as JSON, /metrics for Prometheus, /health. If other machines reach it, a
/// random token is required, which the news tell as part of the address.
extern const SinkKind web_sink;
/// Writes messages of ROS 2 into an MCAP file: /points, /image, of clouds that share no frame.
extern const SinkKind mcap_sink;
/// Clouds, pictures and services of ROS 2 over Cyclone DDS, in the domain of ROS_DOMAIN_ID.
extern const SinkKind ros2_sink;
/// Is a 3-D camera to whoever reads GigE Vision and GenICam: one client at a time gets clouds, as
/// points or depth, with intensity and confidence where it asks for these.
extern const SinkKind genicam_sink;

/// What has become of the clouds that a sink was given.
struct SinkStatistics {
  std::string name;             ///< as it was asked for
  std::uint64_t published = 0;  ///< that it has taken
  std::uint64_t dropped = 0;    ///< that it had no time for, the oldest of those that waited
  std::string error;            ///< why it takes no more; empty where it does
};

/// Gives clouds to sinks, each on its own thread behind a queue that drops its oldest: no waiting.
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
  /// News: to `say` what sinks tell, to `warn` once that one drops clouds or failed. One thread.
  void tell(const std::function<void(const std::string&)>& say,
            const std::function<void(const std::string&)>& warn);

 private:
  struct Outlet;
  std::vector<std::unique_ptr<Outlet>> outlets_;
};

}  // namespace slipstream
