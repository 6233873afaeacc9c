#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

namespace slipstream {

/// A borrowed message of an MCAP file. An attachment has no encoding, and its name as topic.
struct McapMessage {
  const std::string& topic;
  const std::string& type;      ///< schema name, e.g. "sensor_msgs/msg/PointCloud2"
  const std::string& encoding;  ///< "cdr"
  std::uint32_t number;         ///< sequence number given by the writer
  std::uint64_t time;           ///< log time, ns
  std::span<const std::uint8_t> content;
};

/// Calls `see` for each message in order, up to the last complete chunk. Returns whether the file
/// is complete. Throws Error, naming the file, if it is invalid or compressed by anything but zstd,
/// if its chunks unpack to more than 1 GiB and 200 times its size, or if `see` throws.
bool read_mcap(const std::filesystem::path& path,
               const std::function<void(const McapMessage&)>& see);

}  // namespace slipstream
