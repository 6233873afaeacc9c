#include "slipstream/publish/mcap_reader.h"

#include <algorithm>
#include <array>
#include <map>
#include <vector>

#include <fmt/format.h>
#include <zstd.h>

#include "slipstream/base/error.h"
#include "slipstream/io/checksum.h"
#include "slipstream/io/file.h"
#include "slipstream/publish/byte_reader.h"
#include "slipstream/publish/mcap_records.h"

namespace slipstream {
namespace {
using Bytes = std::vector<std::uint8_t>;

/// Bytes of a record, and of a chunk's content.
constexpr std::uint64_t largest_record = std::uint64_t{1} << 30;
/// A block of zstd has 128 KiB at most and takes 4 bytes at least.
constexpr std::uint64_t most_times_smaller = (128 << 10) / 4;

/// What records say, one behind another.
class Records {
 public:
  explicit Records(const std::function<void(const McapMessage&)>& see) : see_(see) {}

  void take(std::uint8_t opcode, std::span<const std::uint8_t> content) {
    ByteReader record(content);
    if (opcode == mcap::chunk) return take_chunk(record);
    if (opcode == mcap::schema) {
      const auto number = record.get<std::uint16_t>();
      types_[number] = record.text();
    } else if (opcode == mcap::channel) {
      const auto number = record.get<std::uint16_t>();
      Channel& channel = channels_[number];
      channel.schema = record.get<std::uint16_t>();
      channel.topic = record.text();
      channel.encoding = record.text();
    } else if (opcode == mcap::message) {
      const auto channel = channels_.find(record.get<std::uint16_t>());
      if (channel == channels_.end()) throw Error("a message is of no channel");
      const auto& [schema, topic, encoding] = channel->second;
      const auto message_number = record.get<std::uint32_t>();
      const auto time = record.get<std::uint64_t>();
      record.get<std::uint64_t>();  // when it was published
      see_({topic, types_[schema], encoding, message_number, time, record.take(record.left())});
    } else if (opcode == mcap::attachment) {
      const auto time = record.get<std::uint64_t>();
      record.get<std::uint64_t>();  // when it was made
      const std::string name(record.text()), type(record.text());
      see_({name, type, "", 0, time, record.take(record.get<std::uint64_t>())});
    }
  }

 private:
  struct Channel {
    std::uint16_t schema = 0;
    std::string topic{}, encoding{};
  };

  void take_chunk(ByteReader& chunk) {
    chunk.take(8 + 8);  // from when to when
    const auto size = chunk.get<std::uint64_t>();
    const auto sum = chunk.get<std::uint32_t>();
    const std::string_view compression = chunk.text();
    std::span<const std::uint8_t> content = chunk.take(chunk.get<std::uint64_t>());
    if (compression == "zstd") {
      if (size > largest_record || size / most_times_smaller > content.size()) {
        throw Error("a chunk says that it is larger than can be");
      }
      unpacked_.resize(size);
      if (ZSTD_decompress(unpacked_.data(), size, content.data(), content.size()) != size) {
        throw Error("a chunk is damaged");
      }
      content = unpacked_;
    } else if (!compression.empty()) {
      throw Error(fmt::format("its chunks are compressed by {}; zstd or none can be read",
                              compression.substr(0, 32)));
    }
    if (sum != 0 && checksum(content) != sum) throw Error("a chunk is damaged");
    for (ByteReader records(content); records.left() > 0;) {
      const auto opcode = records.get<std::uint8_t>();
      const auto record = records.take(records.get<std::uint64_t>());
      if (opcode != mcap::chunk) take(opcode, record);  // there is none in another
    }
  }

  const std::function<void(const McapMessage&)>& see_;
  std::map<std::uint16_t, std::string> types_;
  std::map<std::uint16_t, Channel> channels_;
  Bytes unpacked_;
};

bool read_records(const InputFile& file, Records& records) {
  std::array<std::uint8_t, 8> begin{};
  if (!file.read(0, {begin}) || begin != mcap::magic) throw Error("is no MCAP file");
  Bytes content;
  for (std::uint64_t offset = begin.size();;) {
    std::array<std::uint8_t, 1 + 8> head{};
    if (!file.read(offset, {head})) return false;
    ByteReader reader(head);
    const auto opcode = reader.get<std::uint8_t>();
    const auto length = reader.get<std::uint64_t>();
    offset += head.size();
    if (opcode == mcap::data_end || opcode == mcap::footer) return true;
    if (length > file.size() - offset) return false;  // what was being written
    if ((opcode >= mcap::schema && opcode <= mcap::chunk) || opcode == mcap::attachment) {
      if (length > largest_record) throw Error("a record of it is larger than 1 GiB");
      content.resize(length);
      if (!file.read(offset, {content})) return false;
      records.take(opcode, content);
    }
    offset += length;
  }
}

}  // namespace

bool read_mcap(const std::filesystem::path& path,
               const std::function<void(const McapMessage&)>& see) {
  const InputFile file(path, no_limit);
  Records records(see);
  try {
    return read_records(file, records);
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", path.string(), error.what()));
  }
}

}  // namespace slipstream
