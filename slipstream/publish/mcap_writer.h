#pragma once

#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "slipstream/io/file.h"

namespace slipstream {

/// Messages of several channels in one MCAP file (mcap.dev/spec): chunks compressed by zstd, an
/// index behind each and one of all at the end, checksums. What was written is read up to its last
/// whole chunk where the end is missing.
class McapWriter {
 public:
  /// Throws WorldError where the file cannot be written, as all that follows: then it ends with the
  /// chunk before, and nothing more is written. With none the file that was there before stays.
  explicit McapWriter(const std::filesystem::path& path,
                      OutputFile::Writing writing = OutputFile::Writing::over_time);
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;
  ~McapWriter();  ///< without finish() it ends as if it could not be written

  /// What its messages are, by the name and the text of their definition ("ros2msg") in the
  /// encoding "cdr". Returns the channel's number.
  std::uint16_t add_channel(const std::string& topic, const std::string& schema_name,
                            const std::string& schema);
  /// `time`: nanoseconds of the world's clock since 1970.
  /// `number`: the message's own; else they are counted.
  void write(std::uint16_t channel, std::uint64_t time, std::span<const std::uint8_t> message,
             std::optional<std::uint32_t> number = std::nullopt);
  /// A file within the file: its name and what it is, "application/yaml".
  void attach(const std::string& name, const std::string& media_type, std::uint64_t time,
              std::string_view content);
  /// Ends the chunk where it is full: what is written together is best read together.
  void end_message_group();
  /// Writes the end and gives the file its name; where no message came, what was there before
  /// stays.
  void finish();

 private:
  using Bytes = std::vector<std::uint8_t>;
  struct Index {
    std::uint64_t time, offset;
  };
  struct Chunk {
    std::uint64_t start = 0, end = 0, offset = 0, length = 0, packed = 0, unpacked = 0;
    std::map<std::uint16_t, std::uint64_t> indices{};  ///< where each channel's begins
    std::uint64_t index_length = 0;
  };
  struct Statistics {
    std::uint64_t messages = 0, start = 0, end = 0;
    std::map<std::uint16_t, std::uint64_t> of_channel{};
  };

  void put(std::initializer_list<std::span<const std::uint8_t>> parts);
  void end_chunk();

  std::filesystem::path path_;
  std::unique_ptr<OutputFile> file_;  ///< none once closed
  std::uint64_t offset_ = 0;
  Bytes schemas_, channels_, chunk_, packed_, attachment_indices_;
  std::uint16_t channel_count_ = 0;
  std::uint32_t attachment_count_ = 0;
  Chunk now_;
  std::map<std::uint16_t, std::vector<Index>> index_;
  std::vector<Chunk> chunks_;
  Statistics statistics_;
};

}  // namespace slipstream
