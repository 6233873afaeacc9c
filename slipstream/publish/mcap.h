#pragma once

#include <algorithm>
#include <map>
#include <memory>

#include "slipstream/base/numbers.h"
#include "slipstream/io/file.h"

namespace slipstream {

/// What stands in MCAP files: mcap.dev/spec.
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

/// Adds what a record says: numbers, texts behind their length in 32 bits, and bytes.
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

/// Messages of several channels in one MCAP file (mcap.dev/spec): chunks compressed by zstd, each
/// with its index, one of all at the end, checksums. Without its end it is read by whole chunks.
class McapWriter {
 public:
  /// Throws WorldError where the file cannot be written, as all that follows: then it ends with the
  /// chunk before, and nothing more is written. With none the file that was there before stays.
  explicit McapWriter(const std::filesystem::path& path,
                      OutputFile::Writing writing = OutputFile::Writing::over_time);
  ~McapWriter();  ///< without finish() it ends as if it could not be written

  /// Messages in CDR, defined by a name and a "ros2msg" text. Returns the channel's number.
  std::uint16_t add_channel(const std::string& topic, const std::string& schema_name,
                            const std::string& schema);
  /// `time`: ns of the world's clock since 1970. `number`: the message's own, else its count.
  void write(std::uint16_t channel, std::uint64_t time, std::span<const std::uint8_t> message,
             std::optional<std::uint32_t> number = std::nullopt);
  /// A file within the file: its name and what it is, "application/yaml".
  void attach(const std::string& name, const std::string& media_type, std::uint64_t time,
              std::string_view content);
  /// Ends the chunk where it is full: what is written together is best read together.
  void end_message_group();
  /// Writes the end and gives the file its name; without any message the file before it stays.
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
  std::unique_ptr<OutputFile> file_;  ///< none once closed
  std::uint64_t offset_ = 0;
  Bytes schemas_, channels_, chunk_, packed_, chunk_indices_, attachment_indices_;
  std::uint32_t chunk_count_ = 0, attachment_count_ = 0;
  std::map<std::uint16_t, std::vector<Index>> index_;  ///< of the chunk, by channel
  std::map<std::uint16_t, std::uint64_t> messages_;    ///< of each channel
  Span chunk_times_, times_;
};

/// A borrowed message of an MCAP file. An attached file has no encoding; the topic is its name.
struct McapMessage {
  const std::string& topic;
  const std::string& type;      ///< its schema's name: "sensor_msgs/msg/PointCloud2"
  const std::string& encoding;  ///< "cdr"
  std::uint32_t number;         ///< that its writer gave it
  std::uint64_t time;           ///< when it was logged, ns
  std::span<const std::uint8_t> content;
};

/// Calls `see` for each message in order, as far as the file is whole. Returns whether its end is
/// there. Throws Error, naming the file, if it is invalid, not of zstd or plain, or if `see` does.
bool read_mcap(const std::filesystem::path& path,
               const std::function<void(const McapMessage&)>& see);

}  // namespace slipstream
