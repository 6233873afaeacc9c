#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "base/numbers.h"
#include "io/file.h"
#include "publish/sink_kind.h"

namespace slipstream {

/// MCAP constants, see mcap.dev/spec.
namespace mcap {

inline constexpr std::array<std::uint8_t, 8> magic{0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
enum Opcode : std::uint8_t {
  header = 0x01,
  footer = 0x02,
  schema = 0x03,
  channel = 0x04,
  message = 0x05,
  chunk = 0x06,
  message_index = 0x07,
  chunk_index = 0x08,
  attachment = 0x09,
  attachment_index = 0x0a,
  statistics = 0x0b,
  summary_offset = 0x0e,
  data_end = 0x0f,
};

/// Appends a record's fields: numbers, texts after their 32-bit length, and bytes.
template <class... Values>
void append(std::vector<std::uint8_t>& record, const Values&... values) {
  const auto add = [&](const auto& value) {
    using Value = std::decay_t<decltype(value)>;
    if constexpr (std::is_arithmetic_v<Value>) {
      append_numbers(record, value);
    } else if constexpr (std::is_convertible_v<Value, std::string_view>) {
      append_numbers(record, static_cast<std::uint32_t>(value.size()));
      for (const char letter : value) record.push_back(static_cast<std::uint8_t>(letter));
    } else {
      record.insert(record.end(), value.begin(), value.end());
    }
  };

  (add(values), ...);
}
}  // namespace mcap

/// Writes messages of several channels into one MCAP file (mcap.dev/spec): chunks compressed by
/// zstd, each with an index, a summary at the end, checksums. A truncated file is readable up to
/// its last complete chunk.
class McapWriter {
 public:
  /// Throws WorldError if the file cannot be written, like all functions below: then it ends with
  /// the last complete chunk, and nothing more is written. Without any chunk an existing file
  /// stays.
  explicit McapWriter(const std::filesystem::path& path,
                      OutputFile::Writing writing = OutputFile::Writing::over_time);
  ~McapWriter();  ///< without finish() the file ends as after a failure

  /// Adds a channel of CDR messages, defined by a type name and a "ros2msg" text. Returns its
  /// number.
  std::uint16_t add_channel(const std::string& topic, const std::string& schema_name,
                            const std::string& schema);
  /// `time`: ns since 1970 (Unix time). `number`: the message's own sequence number, else its
  /// count.
  void write(std::uint16_t channel, std::uint64_t time, std::span<const std::uint8_t> message,
             std::optional<std::uint32_t> number = std::nullopt);
  /// Attaches a file with its name and media type, e.g. "application/yaml".
  void attach(const std::string& name, const std::string& media_type, std::uint64_t time,
              std::string_view content);
  /// Ends the chunk if it is full; messages written together stay together.
  void end_message_group();
  /// Bytes in the file, and in the current chunk before compression.
  [[nodiscard]] std::uint64_t bytes() const { return offset_ + chunk_.size(); }
  /// Completes the file and gives it its name; without any message an existing file stays.
  void finish();

 private:
  using Bytes = std::vector<std::uint8_t>;
  struct Index {
    std::uint64_t time, offset;
  };
  struct Span {
    std::uint64_t start = std::numeric_limits<std::uint64_t>::max(), end = 0;
    void take_in(const Span& other) {
      start = std::min(start, other.start);
      end = std::max(end, other.end);
    }
  };

  void put(std::initializer_list<std::span<const std::uint8_t>> parts);
  void end_chunk();

  std::filesystem::path path_;
  std::unique_ptr<OutputFile> file_;  ///< null once closed
  std::uint64_t offset_ = 0;
  Bytes schemas_, channels_, chunk_, packed_, chunk_indices_, attachment_indices_;
  std::uint32_t chunk_count_ = 0, attachment_count_ = 0;
  std::map<std::uint16_t, std::vector<Index>> index_;  ///< the chunk's, by channel
  std::map<std::uint16_t, std::uint64_t> messages_;    ///< per channel
  Span chunk_times_, times_;
};

/// Writes ROS 2 messages into an MCAP file: /points and /image, of clouds that share no frame.
extern const SinkKind mcap_sink;

}  // namespace slipstream
