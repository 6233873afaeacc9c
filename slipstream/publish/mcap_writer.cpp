#include "slipstream/publish/mcap_writer.h"

#include <algorithm>
#include <limits>
#include <memory>

#include <fmt/format.h>
#include <zstd.h>

#include "slipstream/base/error.h"
#include "slipstream/io/checksum.h"
#include "slipstream/publish/mcap_records.h"

namespace slipstream {
namespace {
using namespace std::string_view_literals;
using namespace mcap;
using Bytes = std::vector<std::uint8_t>;

/// A chunk ends once it holds so much.
constexpr std::size_t chunk_bytes = 4 << 20;
/// Of zstd: the fastest ones save nearly as much of 32-bit floats as the thorough ones.
constexpr int compression = -3;

/// What tells what a record is, and how long its content.
void append_head(Bytes& bytes, Opcode opcode, std::uint64_t length) {
  append(bytes, static_cast<std::uint8_t>(opcode), length);
}

void append_record(Bytes& bytes, Opcode opcode, std::span<const std::uint8_t> content) {
  append_head(bytes, opcode, content.size());
  append(bytes, content);
}

Bytes map_of(const std::map<std::uint16_t, std::uint64_t>& values) {
  Bytes bytes;
  append(bytes, static_cast<std::uint32_t>(values.size() * 10));
  for (const auto& [key, value] : values) append(bytes, key, value);
  return bytes;
}

}  // namespace

McapWriter::McapWriter(const std::filesystem::path& path, OutputFile::Writing writing)
    : path_(path) {
  Bytes begin(magic.begin(), magic.end()), content;
  append(content, "ros2"sv, "slipstream"sv);
  append_record(begin, header, content);
  file_ = std::make_unique<OutputFile>(path, writing);  // last: it stays where memory fails
  put({begin});
}

McapWriter::~McapWriter() {
  try {
    if (file_) (void)file_->give_up(chunks_.empty() ? 0 : offset_);
  } catch (const std::exception&) {
    // A destructor has nobody to tell; what was written stays.
  }
}

/// Puts what is read as a whole.
void McapWriter::put(std::initializer_list<std::span<const std::uint8_t>> parts) {
  if (!file_) throw WorldError(fmt::format("{}: is closed", path_.string()));
  try {
    file_->write(parts);
  } catch (const WorldError&) {
    throw WorldError(std::exchange(file_, nullptr)->give_up(chunks_.empty() ? 0 : offset_));
  }
  for (const auto part : parts) offset_ += part.size();
}

std::uint16_t McapWriter::add_channel(const std::string& topic, const std::string& schema_name,
                                      const std::string& text) {
  const std::uint16_t number = ++channel_count_;  // of its schema too; 0 is none
  Bytes content, of_schema, of_channel;
  append(content, number, schema_name, "ros2msg"sv, text);
  append_record(of_schema, schema, content);
  content.clear();
  append(content, number, number, topic, "cdr"sv, std::uint32_t{0});  // no more is told of it
  append_record(of_channel, channel, content);
  append(schemas_, of_schema);
  append(channels_, of_channel);
  append(of_schema, of_channel);
  append(chunk_, of_schema);  // both at once or none
  statistics_.of_channel[number] = 0;
  return number;
}

void McapWriter::write(std::uint16_t number, std::uint64_t time,
                       std::span<const std::uint8_t> content, std::optional<std::uint32_t> own) {
  // All memory before the first byte: where there is none, no half a message is left.
  const std::size_t head = 1 + 8 + 2 + 4 + 8 + 8, needed = chunk_.size() + head + content.size();
  if (needed > chunk_.capacity()) chunk_.reserve(std::max(needed, 2 * chunk_.capacity()));
  if (index_.empty()) now_.start = now_.end = time;
  now_.start = std::min(now_.start, time);
  now_.end = std::max(now_.end, time);
  index_[number].push_back({time, chunk_.size()});
  const auto count = own.value_or(static_cast<std::uint32_t>(statistics_.of_channel[number]));
  ++statistics_.of_channel[number];
  append_head(chunk_, message, 2 + 4 + 8 + 8 + content.size());
  append(chunk_, number, count, time, time, content);  // when it was logged, and published
  ++statistics_.messages;
}

void McapWriter::attach(const std::string& name, const std::string& media_type, std::uint64_t time,
                        std::string_view text) {
  Bytes content, record;
  append(content, time, time, name, media_type, std::uint64_t{text.size()},
         std::span(text.data(), text.size()));
  append(content, checksum(content));
  append_record(record, attachment, content);
  content.clear();
  append(content, offset_, std::uint64_t{record.size()}, time, time, std::uint64_t{text.size()},
         name, media_type);
  append_record(attachment_indices_, attachment_index, content);
  ++attachment_count_;
  put({record});
}

void McapWriter::end_message_group() {
  if (chunk_.size() >= chunk_bytes) end_chunk();
}

void McapWriter::end_chunk() {
  if (index_.empty()) return;
  packed_.resize(ZSTD_compressBound(chunk_.size()));
  const std::size_t size =
      ZSTD_compress(packed_.data(), packed_.size(), chunk_.data(), chunk_.size(), compression);
  if (ZSTD_isError(size) != 0) throw WorldError(ZSTD_getErrorName(size));
  now_.offset = offset_;
  now_.packed = size;
  now_.unpacked = chunk_.size();
  Bytes head, indices;
  append_head(head, chunk, 8 + 8 + 8 + 4 + (4 + 4) + 8 + size);
  append(head, now_.start, now_.end, now_.unpacked, checksum(chunk_), "zstd"sv, now_.packed);
  now_.length = head.size() + size;
  for (const auto& [number, places] : index_) {
    now_.indices[number] = now_.offset + now_.length + indices.size();
    append_head(indices, message_index, 2 + 4 + 16 * places.size());
    append(indices, number, static_cast<std::uint32_t>(16 * places.size()));
    for (const auto& [time, place] : places) append(indices, time, place);
  }
  put({head, {packed_.data(), size}, indices});
  now_.index_length = indices.size();
  const bool first = chunks_.empty();
  statistics_.start = first ? now_.start : std::min(statistics_.start, now_.start);
  statistics_.end = std::max(statistics_.end, now_.end);
  chunks_.push_back(std::exchange(now_, {}));
  index_.clear();
  chunk_.clear();
}

void McapWriter::finish() {
  if (!file_) return;  // what failed was told
  if (statistics_.messages == 0) return std::exchange(file_, nullptr)->discard();
  end_chunk();
  Bytes end, content, offsets;
  append(content, std::uint32_t{0});  // no checksum of all before
  append_record(end, data_end, content);
  put({end});
  const std::uint64_t summary = offset_;
  Bytes records;
  // Of each kind of record, where the records of that kind lie.
  const auto group = [&](Opcode opcode, std::size_t begin) {
    if (records.size() == begin) return;
    append_head(offsets, summary_offset, 1 + 8 + 8);
    append(offsets, static_cast<std::uint8_t>(opcode), summary + begin,
           std::uint64_t{records.size() - begin});
  };
  append(records, schemas_);
  group(schema, 0);
  append(records, channels_);
  group(channel, schemas_.size());
  std::size_t begin = records.size();
  content.clear();
  constexpr std::uint32_t metadata = 0;
  append(content, statistics_.messages, channel_count_, std::uint32_t{channel_count_},
         attachment_count_, metadata, static_cast<std::uint32_t>(chunks_.size()), statistics_.start,
         statistics_.end, map_of(statistics_.of_channel));
  append_record(records, statistics, content);
  group(statistics, begin);
  begin = records.size();
  for (const Chunk& one : chunks_) {
    content.clear();
    append(content, one.start, one.end, one.offset, one.length, map_of(one.indices),
           one.index_length, "zstd"sv, one.packed, one.unpacked);
    append_record(records, chunk_index, content);
  }
  group(chunk_index, begin);
  begin = records.size();
  append(records, attachment_indices_);
  group(attachment_index, begin);
  // The footer's own checksum is of all from the summary on but itself.
  const std::uint64_t offsets_at = summary + records.size();
  append(records, offsets);
  append_head(records, footer, 8 + 8 + 4);
  append(records, summary, offsets_at);
  append(records, checksum(records), magic);
  put({records});
  std::exchange(file_, nullptr)->keep();
}

}  // namespace slipstream
