#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "slipstream/frame_source.h"
#include "slipstream/live_pipeline.h"
#include "slipstream/recording.h"
#include "slipstream/scanner.h"

namespace slipstream {

/// A setting that can change while the run continues, with its present value.
struct RunSetting {
  std::string name;     ///< as in the flags of `slipstream live`: "minimum-modulation"
  std::string help;     ///< short description
  std::string unit{};   ///< unit of a number, e.g. "ms"; empty if none
  std::string value{};  ///< a number, or one of the choices
  std::vector<std::string> choices{};  ///< "off" and "on" for a switch; empty for a number
  double least = 0, most = 0;          ///< range of a number
  std::string state{};                 ///< remark shown beside it; usually empty
};

/// Throws Error, naming valid choices, unless a setting of that name accepts that value.
void require_settable(const std::vector<RunSetting>& settings, const std::string& name,
                      const std::string& value);

/// The run whose clouds are published. Its functions are called from any thread and may throw.
struct PublishedRun {
  Lens camera{};                       ///< camera whose pixel grid the clouds use
  std::string frame_id{camera_frame};  ///< of the camera's frame, in ROS messages
  /// From the camera's frame to the one that points are published in; null: the camera's.
  std::shared_ptr<const FramePose> frame{};
  std::string scanner{};   ///< text of its scanner file; empty if unknown
  bool has_points = true;  ///< whether a scanner is known; otherwise there are only pictures
  std::function<std::string()> statistics{};  ///< the run's statistics so far, as JSON
  std::function<std::string()> trouble{};     ///< one line; empty if all is well
  /// Writes the newest cloud and returns its path. Throws Error within one second of the last call.
  std::function<std::string()> save{};
  /// Wrapped phase of the cloud's frames: 1 to 255 over a period per pixel, 0 if too dark. Empty
  /// for frames of another sequence than the current one. One thread at a time.
  std::function<Image<std::uint8_t>(const LiveCloud&)> phase{};
  /// Null if the noise is unknown; nullopt for frames of another sequence. One thread at a time.
  std::function<std::optional<Uncertainty>(const LiveCloud&)> uncertainty{};
  /// Settings that any sink or the viewer may change now, in a stable order; without those of a
  /// lost camera.
  std::function<std::vector<RunSetting>()> settings{};
  /// Sets a setting by name. Throws Error like require_settable.
  std::function<void(const std::string& name, const std::string& value)> change{};
  FileLimit limit{};  ///< of files
};

/// A destination of clouds: a file, other programs, a browser. A Publisher runs each on its own
/// thread.
class CloudSink {
 public:
  virtual ~CloudSink() = default;

  /// Whether to pass this cloud to the sink. Called in the thread that makes clouds.
  [[nodiscard]] virtual bool wants(const LiveCloud&) { return true; }
  /// Takes the next cloud; may keep at most one. An exception ends only this sink. `alone`: clouds
  /// are waiting and some were dropped, so skip slow additions such as uncertainty or frames.
  virtual void put(const Pooled<LiveCloud>& cloud, bool alone) = 0;
  /// Called after the last cloud. Throws likewise.
  virtual void finish() {}
  /// New status lines since the last call. From any thread.
  virtual std::vector<std::string> news();

 protected:
  /// Adds a status line; ignores repeated ones, and any after 64. From any thread.
  void tell(const std::string& line);

 private:
  std::mutex news_mutex_;  ///< guards the members below
  std::vector<std::string> news_;
  std::set<std::string> reported_;
};

/// A sink that skips clouds sharing a frame with the previous one.
class DisjointCloudSink : public CloudSink {
 public:
  [[nodiscard]] bool wants(const LiveCloud& cloud) final {
    const std::uint64_t newest = cloud.newest.sequence, frames = cloud.frames.size();
    const bool wanted = !last_ || newest < *last_ || newest - *last_ >= frames;
    if (wanted) last_ = newest;
    return wanted;
  }

 private:
  std::optional<std::uint64_t> last_;  ///< number of the newest frame of the last cloud taken
};

/// The available sinks: "web:[ADDRESS:]PORT, tcp:[ADDRESS:]PORT, mcap:FILE, ros2:NAMESPACE,
/// genicam:ADDRESS".
std::string sink_forms();

/// Throws Error, listing the available forms, if `name` is invalid.
void require_sink(const std::string& name);

/// Throws like require_sink, and WorldError if the port is taken or the file cannot be written.
std::unique_ptr<CloudSink> open_sink(const std::string& name, PublishedRun run);

struct SinkStatistics {
  std::string name;             ///< as requested
  std::uint64_t published = 0;  ///< clouds taken
  std::uint64_t dropped = 0;    ///< clouds dropped because the sink was too slow, oldest first
  std::string error;            ///< why it failed; empty while it works
};

/// Passes clouds to sinks, each on its own thread behind a queue that drops its oldest; never
/// waits.
class Publisher {
 public:
  /// Clouds waiting for a sink, plus those it may hold.
  static constexpr std::size_t waiting_clouds = 4, held_clouds = waiting_clouds + 2;

  Publisher();
  ~Publisher();  ///< calls finish()
  Publisher(const Publisher&) = delete;
  Publisher& operator=(const Publisher&) = delete;

  /// Call before the first cloud.
  void add(const std::string& name, std::unique_ptr<CloudSink> sink);
  void publish(const Pooled<LiveCloud>& cloud);
  /// Publishes waiting clouds and ends the sinks, which then no longer call their run.
  void finish();

  /// In the order they were added.
  [[nodiscard]] std::vector<SinkStatistics> statistics() const;
  /// Passes status lines of sinks to `say`, and the first drop or failure of each to `warn`. One
  /// thread.
  void tell(const std::function<void(const std::string&)>& say,
            const std::function<void(const std::string&)>& warn);

 private:
  struct Outlet;
  std::vector<std::unique_ptr<Outlet>> outlets_;
};

}  // namespace slipstream
