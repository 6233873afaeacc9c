#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

namespace slipstream {

/// A message of an MCAP file; all is borrowed. A file that is attached to it is seen as one without
/// encoding: its name as the topic, what it is as the type.
struct McapMessage {
  const std::string& topic;
  const std::string& type;      ///< its schema's name: "sensor_msgs/msg/PointCloud2"
  const std::string& encoding;  ///< "cdr"
  std::uint32_t number;         ///< that its writer gave it
  std::uint64_t time;           ///< when it was logged, ns
  std::span<const std::uint8_t> content;
};

/// Calls `see` for each message in the file's order, as far as the file is whole. Its chunks are
/// compressed by zstd or not at all; its indices are passed over. Returns whether its end is there.
/// Throws Error, naming the file, where it is none, is damaged, or compressed in another way; what
/// `see` throws as Error is of the file, too.
bool read_mcap(const std::filesystem::path& path,
               const std::function<void(const McapMessage&)>& see);

}  // namespace slipstream
