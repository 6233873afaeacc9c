#include <utility>

#include "slipstream/publish/disjoint_clouds.h"
#include "slipstream/publish/mcap_writer.h"
#include "slipstream/publish/named_sink.h"
#include "slipstream/publish/ros_messages.h"

namespace slipstream {
namespace {

class McapSink final : public CloudSink {
 public:
  McapSink(const std::string& path, PublishedRun run) : run_(std::move(run)), writer_(path) {
    image_ = add(image_type(), "/image");
    if (!run_.has_points) return;
    points_ = add(point_cloud_type(), "/points");
  }

  bool wants(const LiveCloud& cloud) override { return clouds_.is_next(cloud); }

  void put(const Pooled<LiveCloud>& cloud) override {
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
  DisjointClouds clouds_;
};

}  // namespace

const SinkKind mcap_sink{
    "mcap", "mcap:FILE",
    [](const std::string& path) { require_ending(path, "MCAP file", {".mcap"}); },
    [](const std::string& path, PublishedRun run) -> std::unique_ptr<CloudSink> {
      return std::make_unique<McapSink>(path, std::move(run));
    }};

}  // namespace slipstream
