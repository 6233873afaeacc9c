// What others may have written of clouds: MCAP files, messages of ROS 2.
#include <cstring>

#include "publish/cdr.h"
#include "publish/mcap.h"
#include "publish/mcap_reader.h"
#include "publish/ros_parameters.h"
#include "slipstream/ros_messages.h"
#include "tests/fuzz/target.h"

namespace slipstream {
namespace {
using namespace std::string_view_literals;
using mcap::append;
namespace fs = std::filesystem;

RosMessage some_cloud(bool with_uncertainty) {
  Cloud cloud({4, 3});
  cloud.x(1, 1) = cloud.y(1, 1) = cloud.z(1, 1) = 500;
  const Uncertainty uncertainty({4, 3});
  RosMessage message;
  write_point_cloud(cloud, {1}, message, with_uncertainty ? &uncertainty : nullptr);
  return message;
}

std::vector<Bytes> clouds() {
  return {some_cloud(false), some_cloud(true)};
}

/// A request begins like any message, and is taken or not.
void answer_requests(std::span<const std::uint8_t> input) {
  const PublishedRun run{.settings = [] { return std::vector<RunSetting>(); },
                         .change = [](const std::string&, const std::string&) {}};
  for (const RosService& service : parameter_services("scanner", run)) {
    try {
      CdrReader request(input);
      RosMessage message;
      Cdr answer(message);
      service.answer(request, answer);
    } catch (const Error&) {
      continue;
    }
  }
}

void read_messages(std::span<const std::uint8_t> input) {
  answer_requests(input);
  const StoredCloud stored = read_point_cloud(input);
  (void)point_count(stored.cloud);
}

void append_record(Bytes& to, mcap::Opcode opcode, const Bytes& content) {
  append(to, static_cast<std::uint8_t>(opcode), std::uint64_t{content.size()});
  append(to, std::span<const std::uint8_t>(content));
}

/// Records as others may write them: before any chunk, or in one that is not packed and has no
/// checksum, which would refuse every change.
Bytes plain_file(bool in_chunk) {
  Bytes schema, channel, message, records, chunk, file(mcap::magic.begin(), mcap::magic.end());
  append(schema, std::uint16_t{1}, "sensor_msgs/msg/PointCloud2"sv, "ros2msg"sv, ""sv);
  append(channel, std::uint16_t{1}, std::uint16_t{1}, "/points"sv, "cdr"sv, std::uint32_t{0});
  append(message, std::uint16_t{1}, std::uint32_t{0}, std::uint64_t{5}, std::uint64_t{5},
         std::span<const std::uint8_t>(some_cloud(false)));
  append_record(records, mcap::schema, schema);
  append_record(records, mcap::channel, channel);
  append_record(records, mcap::message, message);
  append(chunk, std::uint64_t{5}, std::uint64_t{5}, std::uint64_t{records.size()}, std::uint32_t{0},
         ""sv, std::uint64_t{records.size()}, std::span<const std::uint8_t>(records));
  append_record(file, mcap::header, {});
  if (in_chunk) {
    append_record(file, mcap::chunk, chunk);
  } else {
    append(file, std::span<const std::uint8_t>(records));
  }
  append_record(file, mcap::data_end, Bytes(4));
  return file;
}

std::vector<Bytes> files() {
  return {
      plain_file(false), plain_file(true), written_file("clouds.mcap", [](const fs::path& path) {
        McapWriter writer(path);
        const RosType type = point_cloud_type();
        const std::uint16_t points = writer.add_channel("/points", type.name, type.definition);
        for (std::uint64_t time = 0; time < 3; ++time) {
          writer.write(points, time, some_cloud(true));
        }
        const RosType picture = image_type();
        RosMessage frame;
        write_image(Frame({{3, 2}, 8}), {5}, frame);
        writer.write(writer.add_channel("/frames/0", picture.name, picture.definition), 5, frame);
        writer.attach("scan.yaml", "application/yaml", 5, "strategy: {name: pmp}");
        writer.finish();
      })};
}

/// Without the checksums of its chunks, which need not be there.
Bytes without_checksums(std::span<const std::uint8_t> input) {
  Bytes bytes(input.begin(), input.end());
  constexpr std::size_t head = 9, sum = 24;
  for (std::size_t at = mcap::magic.size(); at + head <= bytes.size();) {
    std::uint64_t length = 0;
    std::memcpy(&length, bytes.data() + at + 1, sizeof(length));
    if (length > bytes.size() - at - head) break;
    if (bytes[at] == mcap::chunk && length >= sum + 4) {
      std::fill_n(bytes.begin() + static_cast<std::ptrdiff_t>(at + head + sum), 4, 0);
    }
    at += head + length;
  }
  return bytes;
}

void read_file_of_messages(std::span<const std::uint8_t> input) {
  (void)read_mcap(file_of(input, "clouds.mcap"), [](const McapMessage& message) {
    if (message.encoding.empty()) return;  // an attached file
    if (message.type == image_type().name) {
      (void)read_frame(message.content, 8);
    } else {
      (void)read_point_cloud(message.content);
    }
  });
}

/// Bytes of one that is unpacked, a few times over.
constexpr std::uint64_t bytes_of_zstd = 100'000;

const bool knows_publish_targets =
    add_fuzz_target({"message", clouds, read_messages}) &&
    add_fuzz_target({"mcap", files, read_file_of_messages}, bytes_of_zstd) &&
    add_fuzz_target({"mcap.repaired", files,
                     [](std::span<const std::uint8_t> input) {
                       read_file_of_messages(without_checksums(input));
                     }},
                    bytes_of_zstd);

}  // namespace
}  // namespace slipstream
