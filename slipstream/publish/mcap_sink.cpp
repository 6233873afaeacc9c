#include <map>
#include <optional>
#include <utility>
#include <vector>

#include <fmt/format.h>

#include "slipstream/io/scan_folder.h"
#include "slipstream/publish/mcap.h"
#include "slipstream/publish/ros_messages.h"

namespace slipstream {
namespace {

class McapSink final : public DisjointCloudSink {
 public:
  McapSink(const std::string& path, PublishedRun run) : run_(std::move(run)), writer_(path) {
    add(image_topic());
    if (run_.statistics) statistics_ = add(string_type(), "statistics");
    if (!run_.has_points) return;
    add(points_topic());
    add(camera_info_topic());
  }

  void put(const Pooled<LiveCloud>& cloud, bool alone) override {
    const PublishedCloud published{*cloud, run_, alone};
    if (run_.sequence && !alone) put_frames(*cloud);
    for (const auto& [channel, topic] : topics_) {
      topic.write(published, message_);
      writer_.write(channel, published.time, message_);
    }
    if (run_.statistics && published.time >= next_statistics_) {
      write_string(run_.statistics(), message_);
      writer_.write(statistics_, published.time, message_);
      next_statistics_ = published.time + second;
    }
    writer_.end_message_group();
  }

  void finish() override { writer_.finish(); }

 private:
  static constexpr std::uint64_t second = 1'000'000'000;  ///< ns

  std::uint16_t add(const RosType& type, const std::string& topic) {
    return writer_.add_channel("/" + topic, type.name, type.definition);
  }
  void add(const CloudTopic& topic) { topics_.emplace_back(add(topic.type, topic.name), topic); }

  /// As they came, each on the topic of its pattern. Those of a strategy that has just been changed
  /// are left out.
  void put_frames(const LiveCloud& cloud) {
    const Sequence window = run_.sequence(), cycle = cycle_of(window);
    if (cloud.frames.size() != static_cast<std::size_t>(frame_count(window))) return;
    const auto patterns = static_cast<std::size_t>(frame_count(cycle));
    attach_scan(cycle, *cloud.frames.front());
    std::map<std::uint64_t, std::pair<std::size_t, const Frame*>> in_time;
    for (std::size_t n = 0; n < cloud.frames.size(); ++n) {
      const std::size_t pattern = (static_cast<std::size_t>(cloud.first_pattern) + n) % patterns;
      in_time[cloud.frames[n]->stamp.sequence] = {pattern, &*cloud.frames[n]};
    }
    for (const auto& [number, frame] : in_time) {
      const auto& [pattern, picture] = frame;
      while (frames_.size() <= pattern) {
        frames_.push_back(add(image_type(), fmt::format("frames/{}", frames_.size())));
      }
      const std::uint64_t time = world_time(picture->stamp.host_time);
      write_image(*picture, time, message_);
      writer_.write(frames_[pattern], time, message_, static_cast<std::uint32_t>(number));
    }
  }

  /// What the frames show from now on, where that is not as before.
  void attach_scan(const Sequence& sequence, const Frame& frame) {
    if (sequence == sequence_) return;
    const std::uint64_t time = world_time(frame.stamp.host_time);
    ScanFiles scan{.sequence = sequence, .bits = frame.bits};
    if (!run_.scanner.empty()) {
      scan.scanner = "scanner.yaml";
      if (!sequence_) writer_.attach("scanner.yaml", "application/yaml", time, run_.scanner);
    }
    writer_.attach("scan.yaml", "application/yaml", time, scan_yaml_of(scan, {}));
    sequence_ = sequence;
  }

  PublishedRun run_;
  McapWriter writer_;
  std::vector<std::pair<std::uint16_t, CloudTopic>> topics_;  ///< by channel
  std::uint16_t statistics_ = 0;
  std::vector<std::uint16_t> frames_;  ///< by pattern
  std::optional<Sequence> sequence_;   ///< that is attached
  std::uint64_t next_statistics_ = 0;
  RosMessage message_;
};

}  // namespace

const SinkKind mcap_sink{
    "mcap", "mcap:FILE",
    [](const std::string& path) { require_ending(path, "MCAP file", {".mcap"}); },
    [](const std::string& path, PublishedRun run) -> std::unique_ptr<CloudSink> {
      return std::make_unique<McapSink>(path, std::move(run));
    }};

}  // namespace slipstream
