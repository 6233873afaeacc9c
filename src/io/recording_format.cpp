#include "io/recording_format.h"

#include <cstdint>
#include <initializer_list>

#include "io/file.h"

namespace slipstream::recording_format {

std::uint64_t record_size(const FrameFormat& format) {
  return sizeof(RecordHeader) + aligned(byte_count(format));
}

std::uint32_t checksum(std::initializer_list<Bytes> parts) {
  std::uint32_t sum = 0;
  for (const Bytes part : parts) sum = slipstream::checksum(part, sum);
  return sum;
}

std::uint32_t checksum_of(const FileHeader& header, Bytes texts) {
  return checksum({bytes_of(header).first(sizeof(header) - sizeof(header.checksum)), texts});
}

bool is_possible(std::int64_t time) {
  constexpr std::int64_t limit = std::int64_t{1} << 61;
  return -limit < time && time < limit;
}

}  // namespace slipstream::recording_format
