#include "publish/mcap_reader.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <zstd.h>

#include "base/throw_if-inl.h"
#include "io/file.h"
#include "publish/cdr.h"
#include "publish/mcap.h"

namespace slipstream {
namespace {
using namespace mcap;

/// Limits of a record and of a chunk's content, bytes.
constexpr std::uint64_t largest_record = std::uint64_t{1} << 30;
/// A block of zstd has 128 KiB at most and takes 4 bytes at least.
constexpr std::uint64_t most_times_smaller = (128 << 10) / 4;
/// All chunks of a file together unpack to largest_record and this many times its size.
constexpr std::uint64_t most_times_of_file = 200;

/// Decodes records and passes on their messages.
class Records {
 public:
  Records(const std::function<void(const McapMessage&)>& see, std::uint64_t file_bytes)
      : see_(see), left_to_unpack_(largest_record + most_times_of_file * file_bytes) {}

  void take(std::uint8_t opcode, std::span<const std::uint8_t> content) {
    ByteReader record(content);
    if (opcode == chunk) return take_chunk(record);

    if (opcode == schema) {
      const auto number = record.get<std::uint16_t>();
      types_[number] = record.text();
    } else if (opcode == channel) {
      const auto number = record.get<std::uint16_t>();
      Channel& channel = channels_[number];
      channel.schema = record.get<std::uint16_t>();
      channel.topic = name_in(record);
      channel.encoding = name_in(record);
    } else if (opcode == message) {
      // The channel has the message's topic, and by its schema the type.
      const auto channel = channels_.find(record.get<std::uint16_t>());
      if (channel == channels_.end()) throw Error("a message has no channel");
      const auto& [schema, topic, encoding] = channel->second;

      const auto message_number = record.get<std::uint32_t>();
      const auto time = record.get<std::uint64_t>();
      record.get<std::uint64_t>();  // publish time
      see_({topic, types_[schema], encoding, message_number, time, record.take(record.left())});
    } else if (opcode == attachment) {
      const auto time = record.get<std::uint64_t>();
      record.get<std::uint64_t>();  // creation time
      const std::string name(record.text()), type(record.text());
      see_({name, type, "", 0, time, record.take(record.get<std::uint64_t>())});
    }
  }

 private:
  struct Channel {
    std::uint16_t schema = 0;
    std::string topic{}, encoding{};
  };

  /// A text that comes with each message of a channel.
  static std::string_view name_in(ByteReader& record) {
    constexpr std::size_t longest = 4096;
    const std::string_view name = record.text();
    throw_if(name.size() > longest, "a channel's name has {} letters; limit {}", name.size(),
             longest);
    return name;
  }

  void take_chunk(ByteReader& chunk) {
    // 1. The chunk's head.
    chunk.take(8 + 8);  // time range
    const auto size = chunk.get<std::uint64_t>();
    const auto sum = chunk.get<std::uint32_t>();
    const std::string_view compression = chunk.text();
    std::span<const std::uint8_t> content = chunk.take(chunk.get<std::uint64_t>());

    // 2. Unpack it, after a check that the stated size is possible: the file is not trusted.
    if (compression == "zstd") {
      throw_if(size > largest_record || size / most_times_smaller > content.size(),
               "a chunk states an impossible size");
      throw_if(size > left_to_unpack_, "its chunks unpack to more than 1 GiB and {} times its size",
               most_times_of_file);
      left_to_unpack_ -= size;
      unpacked_.resize(size);
      throw_if(ZSTD_decompress(unpacked_.data(), size, content.data(), content.size()) != size,
               "a chunk is damaged");
      content = unpacked_;
    } else if (!compression.empty()) {
      throw Error(
          fmt::format("its chunks are compressed by {}; only zstd or no compression can be read",
                      compression.substr(0, 32)));
    }

    // 3. Take its records. A checksum of 0 means that there is none.
    if (sum != 0 && checksum(content) != sum) throw Error("a chunk is damaged");

    for (ByteReader records(content); records.left() > 0;) {
      const auto opcode = records.get<std::uint8_t>();
      const auto record = records.take(records.get<std::uint64_t>());
      if (opcode != mcap::chunk) take(opcode, record);  // chunks do not nest
    }
  }

  const std::function<void(const McapMessage&)>& see_;
  std::map<std::uint16_t, std::string> types_;
  std::map<std::uint16_t, Channel> channels_;
  std::vector<std::uint8_t> unpacked_;
  std::uint64_t left_to_unpack_;  ///< bytes
};

bool read_records(const InputFile& file, Records& records) {
  std::array<std::uint8_t, 8> begin{};
  if (!file.read(0, {begin}) || begin != magic) throw Error("not an MCAP file");

  std::vector<std::uint8_t> content;
  for (std::uint64_t offset = begin.size();;) {
    // Opcode and length.
    std::array<std::uint8_t, 1 + 8> head{};
    if (!file.read(offset, {head})) return false;
    ByteReader reader(head);
    const auto opcode = reader.get<std::uint8_t>();
    const auto length = reader.get<std::uint64_t>();
    offset += head.size();

    if (opcode == data_end || opcode == footer) return true;
    if (length > file.size() - offset) return false;  // an incomplete last record

    // Records of other kinds, such as indices, are skipped.
    if ((opcode >= schema && opcode <= chunk) || opcode == attachment) {
      if (length > largest_record) throw Error("has a record larger than 1 GiB");
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
  Records records(see, file.size());
  return naming(path.string(), [&] { return read_records(file, records); });
}

}  // namespace slipstream
