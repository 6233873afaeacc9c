#include <chrono>
#include <optional>
#include <utility>

#include "slipstream/publish/mcap_writer.h"
#include "slipstream/publish/named_sink.h"
#include "slipstream/publish/ros_messages.h"
#include "slipstream/publish/thread_priority.h"

namespace slipstream {
namespace {

std::uint64_t world_time(std::chrono::steady_clock::time_point time) {
  const auto age = std::chrono::steady_clock::now() - time;
  const auto since_1970 = (std::chrono::system_clock::now() - age).time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::nanoseconds(since_1970).count());
}

class McapSink final : public CloudSink {
 public:
  McapSink(const std::string& path, PublishedRun run) : run_(std::move(run)), writer_(path) {
    image_ = add(image_type(), "/image");
    if (!run_.has_points) return;
    points_ = add(point_cloud_type(), "/points");
  }

  bool wants(const LiveCloud& cloud) override {
    const std::uint64_t newest = cloud.newest.sequence, frames = cloud.frames.size();
    const bool wanted = !last_ || newest < *last_ || newest - *last_ >= frames;
    if (wanted) last_ = newest;
    return wanted;
  }

  void put(const Pooled<LiveCloud>& cloud) override {
    if (!std::exchange(gives_way_, true)) let_others_go_first();
    const std::uint64_t time = world_time(cloud->newest.host_time);
    write_image(*cloud, time, message_);
    writer_.write(image_, time, message_);
    if (run_.has_points) {
      write_point_cloud(cloud->cloud, time, message_);
      writer_.write(points_, time, message_);
    }
    writer_.end_message_group();
  }

  void finish() override { writer_.finish(); }

 private:
  std::uint16_t add(const RosType& type, const std::string& topic) {
    return writer_.add_channel(topic, type.name, type.definition);
  }

  PublishedRun run_;
  McapWriter writer_;
  std::uint16_t image_ = 0, points_ = 0;
  RosMessage message_;
  bool gives_way_ = false;             ///< its thread
  std::optional<std::uint64_t> last_;  ///< sequence of the newest frame of what was wanted last
};

}  // namespace

const SinkKind mcap_sink{
    "mcap", "mcap:FILE",
    [](const std::string& path) { require_ending(path, "MCAP file", {".mcap"}); },
    [](const std::string& path, PublishedRun run) -> std::unique_ptr<CloudSink> {
      return std::make_unique<McapSink>(path, std::move(run));
    }};

}  // namespace slipstream
