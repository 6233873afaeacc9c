#include "slipstream/io/checksum.h"

#include <algorithm>
#include <vector>

#include <libdeflate.h>

#include "slipstream/io/file.h"
#include "slipstream/io/recorded_cycle.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// Of a recording its header, and of the one that is the scan its frames.
std::uint32_t checksum_of(const fs::path& file, std::uint32_t before) {
  return is_recording(file) ? RecordingReader(file).checksum(0, 0, before)
                            : checksum_of_file(file, before);
}

}  // namespace

std::uint32_t checksum(std::span<const std::uint8_t> bytes, std::uint32_t before) {
  return bytes.empty() ? before : libdeflate_crc32(before, bytes.data(), bytes.size());
}

std::uint32_t checksum_of_file(const fs::path& path, std::uint32_t before) {
  const InputFile file(path, no_limit);
  std::vector<std::uint8_t> bytes;
  for (std::uint64_t at = 0; at < file.size(); at += bytes.size()) {
    bytes.resize(std::min(file.size() - at, std::uint64_t{1} << 20));
    if (!file.read(at, {bytes})) break;
    before = checksum(bytes, before);
  }
  return before;
}

std::uint32_t checksum_of(const ScanFiles& scan) {
  std::uint32_t sum =
      scan.second_camera ? checksum_of(scan_files_in(*scan.second_camera)) : std::uint32_t{0};
  if (scan.recording) {
    sum = cycle_checksum(*scan.recording, scan.sequence, scan.window, sum);
  }
  std::vector<fs::path> files = scan.frames;
  if (fs::exists(scan.path / "scan.yaml")) files.push_back(scan.path / "scan.yaml");
  if (scan.scanner) files.push_back(*scan.scanner);
  for (const fs::path& file : files) {
    sum = scan.recording && file == scan.path ? scan.recording->checksum(0, 0, sum)
                                              : checksum_of(file, sum);
  }
  return sum;
}

}  // namespace slipstream
