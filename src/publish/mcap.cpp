#include "publish/mcap.h"

#include <array>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <zstd.h>

#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/recorder.h"
#include "io/scan_folder.h"
#include "publish/cdr.h"
#include "publish/sink_kind.h"
#include "publish/transform_message.h"
#include "slipstream/ros_messages.h"
#include "slipstream/scan_files.h"

namespace slipstream {
namespace {
using namespace std::string_view_literals;
using namespace mcap;
using Bytes = std::vector<std::uint8_t>;

/// A chunk ends once it holds this many bytes.
constexpr std::size_t chunk_bytes = 4 << 20;
constexpr std::uint32_t metadata = 0;  // none
/// zstd level: for 32-bit floats the fastest levels save nearly as much as the slow ones.
constexpr int compression = -3;

/// A record's opcode and length.
void append_head(Bytes& bytes, Opcode opcode, std::uint64_t length) {
  append(bytes, static_cast<std::uint8_t>(opcode), length);
}

template <class... Values>
void append_record(Bytes& bytes, Opcode opcode, const Values&... values) {
  Bytes content;
  append(content, values...);
  append_head(bytes, opcode, content.size());
  append(bytes, content);
}

Bytes map_of(const std::map<std::uint16_t, std::uint64_t>& values) {
  Bytes bytes;
  append(bytes, static_cast<std::uint32_t>(values.size() * 10));
  for (const auto& [key, value] : values) append(bytes, key, value);
  return bytes;
}

/// One file of clouds.
class McapClouds {
 public:
  McapClouds(const std::filesystem::path& path, const PublishedRun& run)
      : run_(run), writer_(path) {
    add(image_topic());
    if (run_.statistics) statistics_ = add({"std_msgs/msg/String", "string data\n"}, "statistics");

    if (!run_.has_points) return;
    add(points_topic());
    add(camera_info_topic());
    if (run_.frame) transform_ = add(transform_type(), std::string(transform_topic));
  }

  void put(const Pooled<LiveCloud>& cloud, bool alone) {
    // With frames, unless the sink is too slow for them.
    const PublishedCloud published{*cloud, run_, alone};
    if (cloud->sequence && !alone) put_frames(*cloud);

    // Each file says once where the camera is.
    if (transform_) {
      write_transform(*run_.frame, run_.frame_id, published.header.time, message_);
      writer_.write(*std::exchange(transform_, std::nullopt), published.header.time, message_);
    }

    for (const auto& [channel, topic] : topics_) {
      topic.write(published, message_);
      writer_.write(channel, published.header.time, message_);
    }

    // Statistics once per second.
    if (run_.statistics && published.header.time >= next_statistics_) {
      Cdr(message_).add_text(run_.statistics());
      writer_.write(statistics_, published.header.time, message_);
      next_statistics_ = published.header.time + second;
    }

    writer_.end_message_group();
  }

  [[nodiscard]] std::uint64_t bytes() const { return writer_.bytes(); }
  void finish() { writer_.finish(); }

 private:
  static constexpr std::uint64_t second = 1'000'000'000;  ///< ns

  std::uint16_t add(const RosType& type, const std::string& topic) {
    return writer_.add_channel("/" + topic, type.name, type.definition);
  }

  void add(const CloudTopic& topic) { topics_.emplace_back(add(topic.type, topic.name), topic); }

  /// Frames as received, each on its pattern's topic.
  void put_frames(const LiveCloud& cloud) {
    const Sequence cycle = cycle_of(*cloud.sequence);
    const auto patterns = static_cast<std::size_t>(frame_count(cycle));
    attach_scan(cycle, *cloud.frames.front());

    // In the order of their capture, which in a window need not be the order of the patterns.
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
      write_image(*picture, {time, run_.frame_id}, message_);
      writer_.write(frames_[pattern], time, message_, static_cast<std::uint32_t>(number));
    }
  }

  /// Writes the sequence if it has changed.
  void attach_scan(const Sequence& sequence, const Frame& frame) {
    if (sequence == sequence_) return;

    const std::uint64_t time = world_time(frame.stamp.host_time);
    ScanFiles scan{.sequence = sequence, .bits = frame.bits};
    // The scanner does not change, so attach it once.
    if (!run_.scanner.empty()) {
      scan.scanner = "scanner.yaml";
      if (!sequence_) writer_.attach("scanner.yaml", "application/yaml", time, run_.scanner);
    }

    writer_.attach("scan.yaml", "application/yaml", time, scan_yaml_of(scan, {}));
    sequence_ = sequence;
  }

  const PublishedRun& run_;
  McapWriter writer_;
  std::vector<std::pair<std::uint16_t, CloudTopic>> topics_;  ///< by channel
  std::uint16_t statistics_ = 0;
  std::optional<std::uint16_t> transform_;  ///< channel, until it is written
  std::vector<std::uint16_t> frames_;       ///< by pattern
  std::optional<Sequence> sequence_;        ///< as attached
  std::uint64_t next_statistics_ = 0;
  RosMessage message_;
};

class McapSink final : public DisjointCloudSink {
 public:
  McapSink(const std::string& path, PublishedRun run)
      : run_(std::move(run)), file_(path, run_.limit), clouds_(std::in_place, path, run_) {}

  void put(const Pooled<LiveCloud>& cloud, bool alone) override {
    // A full file is completed; this cloud begins the next one, if the limit allows it.
    if (clouds_ && file_.is_full(clouds_->bytes())) {
      clouds_->finish();
      clouds_.reset();
      if (file_.goes_on()) clouds_.emplace(file_.path, run_);
      tell(file_.message());
    }

    if (clouds_) clouds_->put(cloud, alone);
  }

  void finish() override {
    if (clouds_) clouds_->finish();
  }

 private:
  const PublishedRun run_;
  LimitedFile file_;
  std::optional<McapClouds> clouds_;  ///< nullopt after the limit
};

}  // namespace

McapWriter::McapWriter(const std::filesystem::path& path, OutputFile::Writing writing)
    : path_(path) {
  Bytes begin(magic.begin(), magic.end());
  append_record(begin, header, "ros2"sv, "slipstream"sv);
  file_ = std::make_unique<OutputFile>(path, writing);  // last: kept if memory runs out before
  put({begin});
}

McapWriter::~McapWriter() {
  try {
    if (file_) (void)file_->give_up(chunk_count_ == 0 ? 0 : offset_);
  } catch (const std::exception&) {
    // A destructor cannot report failures; complete chunks stay.
  }
}

/// Writes a complete chunk.
void McapWriter::put(std::initializer_list<std::span<const std::uint8_t>> parts) {
  if (!file_) throw WorldError(fmt::format("{}: is closed", path_.string()));

  try {
    file_->write(parts);
  } catch (const WorldError&) {
    // The file ends with its last complete chunk.
    throw WorldError(std::exchange(file_, nullptr)->give_up(chunk_count_ == 0 ? 0 : offset_));
  }

  for (const auto part : parts) offset_ += part.size();
}

std::uint16_t McapWriter::add_channel(const std::string& topic, const std::string& schema_name,
                                      const std::string& text) {
  const auto number = static_cast<std::uint16_t>(messages_.size() + 1);  // also its schema's
  Bytes of_schema, of_channel;
  append_record(of_schema, schema, number, schema_name, "ros2msg"sv, text);
  append_record(of_channel, channel, number, number, topic, "cdr"sv, metadata);

  // Kept for the summary at the end, and written into the present chunk.
  append(schemas_, of_schema);
  append(channels_, of_channel);
  append(of_schema, of_channel);
  append(chunk_, of_schema);  // both or neither

  messages_[number] = 0;
  return number;
}

void McapWriter::write(std::uint16_t number, std::uint64_t time,
                       std::span<const std::uint8_t> content, std::optional<std::uint32_t> own) {
  // Reserves all memory first, so that running out leaves no half message.
  const std::size_t head = 1 + 8 + 2 + 4 + 8 + 8, needed = chunk_.size() + head + content.size();
  if (needed > chunk_.capacity()) chunk_.reserve(std::max(needed, 2 * chunk_.capacity()));

  // The index has the message's time, and its place in the chunk before compression.
  chunk_times_.take_in({time, time});
  index_[number].push_back({time, chunk_.size()});
  const auto counted = static_cast<std::uint32_t>(messages_[number]++);

  append_head(chunk_, message, 2 + 4 + 8 + 8 + content.size());
  append(chunk_, number, own.value_or(counted), time, time, content);  // log and publish time
}

void McapWriter::attach(const std::string& name, const std::string& media_type, std::uint64_t time,
                        std::string_view text) {
  Bytes content, record;
  append(content, time, time, name, media_type, std::uint64_t{text.size()},
         std::span(text.data(), text.size()));

  append_record(record, attachment, content, checksum(content));
  append_record(attachment_indices_, attachment_index, offset_, std::uint64_t{record.size()}, time,
                time, std::uint64_t{text.size()}, name, media_type);

  ++attachment_count_;
  put({record});
}

void McapWriter::end_message_group() {
  if (chunk_.size() >= chunk_bytes) end_chunk();
}

void McapWriter::end_chunk() {
  if (index_.empty()) return;

  // 1. Compress the messages.
  packed_.resize(ZSTD_compressBound(chunk_.size()));
  const std::size_t size =
      ZSTD_compress(packed_.data(), packed_.size(), chunk_.data(), chunk_.size(), compression);
  if (ZSTD_isError(size) != 0) throw WorldError(ZSTD_getErrorName(size));

  // 2. The chunk's head.
  const auto& [start, end] = chunk_times_;
  const std::uint64_t packed = size, unpacked = chunk_.size(), offset = offset_;
  Bytes head, indices;
  append_head(head, chunk, 8 + 8 + 8 + 4 + (4 + 4) + 8 + size);
  append(head, start, end, unpacked, checksum(chunk_), "zstd"sv, packed);

  // 3. After the chunk, an index of its messages for each channel.
  const std::uint64_t length = head.size() + size;
  std::map<std::uint16_t, std::uint64_t> begins;  // per channel index
  for (const auto& [number, places] : index_) {
    begins[number] = offset + length + indices.size();
    append_head(indices, message_index, 2 + 4 + 16 * places.size());
    append(indices, number, static_cast<std::uint32_t>(16 * places.size()));
    for (const auto& [time, place] : places) append(indices, time, place);
  }

  // 4. Write it all, and note the chunk for the summary.
  put({head, {packed_.data(), size}, indices});
  append_record(chunk_indices_, chunk_index, start, end, offset, length, map_of(begins),
                std::uint64_t{indices.size()}, "zstd"sv, packed, unpacked);

  // 5. Begin the next chunk.
  ++chunk_count_;
  times_.take_in(std::exchange(chunk_times_, {}));
  index_.clear();
  chunk_.clear();
}

void McapWriter::finish() {
  if (!file_) return;  // the failure was reported before
  end_chunk();
  if (chunk_count_ == 0) return std::exchange(file_, nullptr)->discard();

  // 1. End the data section.
  Bytes end;
  append_record(end, data_end, std::uint32_t{0});  // no checksum of the data section
  put({end});

  // 2. The summary: each kind of record in a group, so that readers find them without the data.
  const std::uint64_t summary = offset_;
  Bytes records, offsets;
  // Position of each kind of record in the summary.
  const auto add_group = [&](Opcode opcode, const Bytes& group) {
    if (group.empty()) return;
    append_record(offsets, summary_offset, static_cast<std::uint8_t>(opcode),
                  summary + records.size(), std::uint64_t{group.size()});
    append(records, group);
  };

  Bytes counts;
  std::uint64_t messages = 0;
  for (const auto& [number, count] : messages_) messages += count;
  append_record(counts, statistics, messages, static_cast<std::uint16_t>(messages_.size()),
                static_cast<std::uint32_t>(messages_.size()), attachment_count_, metadata,
                chunk_count_, times_.start, times_.end, map_of(messages_));

  add_group(schema, schemas_);
  add_group(channel, channels_);
  add_group(statistics, counts);
  add_group(chunk_index, chunk_indices_);
  add_group(attachment_index, attachment_indices_);

  // 3. Positions of the groups, then the footer, whose checksum covers everything from the summary
  // to itself.
  const std::uint64_t offsets_at = summary + records.size();
  append(records, offsets);
  append_head(records, footer, 8 + 8 + 4);
  append(records, summary, offsets_at);
  append(records, checksum(records), magic);

  put({records});
  std::exchange(file_, nullptr)->keep();
}

const SinkKind mcap_sink{
    "mcap", "mcap:FILE",
    [](const std::string& path) { require_ending(path, "MCAP file", {".mcap"}); },
    [](const std::string& path, PublishedRun run) -> std::unique_ptr<CloudSink> {
      return std::make_unique<McapSink>(path, std::move(run));
    }};

}  // namespace slipstream
