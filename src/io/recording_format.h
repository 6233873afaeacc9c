#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <type_traits>
#include <variant>

#include "slipstream/frame_source.h"

// The parts of a recording's file, as docs/reference/clouds-and-recordings.md specifies them.
namespace slipstream::recording_format {

static_assert(std::endian::native == std::endian::little,
              "recordings are little-endian; this machine is not");

inline constexpr std::array<char, 8> recording_magic{'S', 'L', 'I', 'P', 'F', 'R', 'M', 'S'};
inline constexpr std::array<char, 4> end_mark{'E', 'N', 'D', '.'};

/// Versions for grey and colour: readers that only know grey must reject colour.
inline constexpr std::uint32_t grey_version = 1, colour_version = 2;
inline constexpr std::uint32_t channels = 3;

/// Alignment of headers and records, bytes.
inline constexpr std::uint64_t alignment = 64;

struct FileHeader {
  std::array<char, 8> recording_magic{};
  std::uint32_t version = 0;
  std::uint32_t header_size = 0;  ///< offset of the first record
  std::uint32_t width = 0, height = 0, bits = 0, scan_length = 0, scanner_length = 0;
  std::uint32_t channels = 0;  ///< 3 in colour, otherwise 0
  double frame_rate = 0;
  std::uint64_t record_size = 0;
  std::uint32_t white_length = 0;  ///< of the third text: the pixels of the white picture
  std::uint32_t checksum = 0;      ///< of the fields before it, then of the bytes up to header_size
};
static_assert(sizeof(FileHeader) == alignment);

struct RecordHeader {
  std::uint32_t checksum = 0;  ///< of the rest of the record
  std::int32_t pattern_index = -1;
  std::uint64_t index = 0;  ///< of the record in the file
  std::uint64_t sequence = 0;
  std::int64_t device_time = 0;  ///< ns
  std::int64_t host_time = 0;    ///< ns since the first record
  std::array<std::uint8_t, 24> reserved{};
};
static_assert(sizeof(RecordHeader) == alignment);

struct End {
  std::uint32_t checksum = 0;  ///< of the fields after it
  std::array<char, 4> mark = end_mark;
  std::uint64_t count = 0;
};
static_assert(sizeof(End) < sizeof(RecordHeader));

inline constexpr std::array<std::uint8_t, alignment> zeros{};

using Bytes = std::span<const std::uint8_t>;

template <class Value>
Bytes bytes_of(const Value& value) {
  return {reinterpret_cast<const std::uint8_t*>(&value), sizeof(value)};
}

template <class Value>
std::span<std::uint8_t> writable_bytes_of(Value& value) {
  return {reinterpret_cast<std::uint8_t*>(&value), sizeof(value)};
}

constexpr std::uint64_t aligned(std::uint64_t size) {
  return (size + alignment - 1) / alignment * alignment;
}

/// Bytes of a frame with its header.
std::uint64_t record_size(const FrameFormat& format);

/// The memory of the frame's pixels.
template <class AnyFrame>
auto pixel_bytes(AnyFrame& frame) {
  using Byte = std::conditional_t<std::is_const_v<AnyFrame>, const std::uint8_t, std::uint8_t>;
  return std::visit(
      [size = byte_count(frame.format())](auto& image) {
        return std::span(reinterpret_cast<Byte*>(image.begin()), size);
      },
      frame.pixels);
}

/// CRC-32 of the concatenated parts.
std::uint32_t checksum(std::initializer_list<Bytes> parts);

/// Checksum of parts that begin with their own checksum, which is skipped.
template <class Begin, class... Rest>
std::uint32_t checksum_behind(const Begin& begin, Rest... rest) {
  return checksum({bytes_of(begin).subspan(sizeof(begin.checksum)), rest...});
}

/// Checksum of the header without its own, and the texts after it.
std::uint32_t checksum_of(const FileHeader& header, Bytes texts);

/// Whether sums and differences of such times, ns, cannot overflow: up to 73 years.
bool is_possible(std::int64_t time);

}  // namespace slipstream::recording_format
