// Frames: pictures, recordings, and pixels as cameras give them.
#include <bit>
#include <cstring>

#include "frames/scan_camera.h"
#include "io/file.h"
#include "io/image_file.h"
#include "slipstream/camera.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/recording.h"
#include "tests/fuzz/target.h"
#include "tests/recording/recorded_frames.h"

namespace slipstream {
namespace {
namespace fs = std::filesystem;

std::vector<Bytes> pictures(const std::string& ending) {
  Image<std::uint8_t> picture({12, 9});
  Image<std::uint16_t> deep({5, 4});
  std::uint8_t value = 0;
  for (std::uint8_t& pixel : picture) pixel = value += 7;
  for (std::uint16_t& pixel : deep) pixel = static_cast<std::uint16_t>(251 * (value += 7));
  std::vector<Bytes> seeds{
      written_file("grey" + ending, [&](const fs::path& path) { write_image(path, picture); })};
  if (ending != ".bmp") {
    seeds.push_back(
        written_file("deep" + ending, [&](const fs::path& path) { write_image(path, deep); }));
  }
  return seeds;
}

/// 6x4 pixels of grey level 77, in hexadecimal.
constexpr std::string_view grey_jpeg =
    "ffd8ffe000104a46494600010100000100010000ffdb00430003020203020203030303040303040508050504"
    "04050a070706080c0a0c0c0b0a0b0b0d0e12100d0e110e0b0b1016101113141515150c0f1718161418121415"
    "14ffc0000b080004000601011100ffc4001f0000010501010101010100000000000000000102030405060708"
    "090a0bffc400b5100002010303020403050504040000017d0102030004110512213141061351610722711432"
    "8191a1082342b1c11552d1f02433627282090a161718191a25262728292a3435363738393a43444546474849"
    "4a535455565758595a636465666768696a737475767778797a838485868788898a92939495969798999aa2a3"
    "a4a5a6a7a8a9aab2b3b4b5b6b7b8b9bac2c3c4c5c6c7c8c9cad2d3d4d5d6d7d8d9dae1e2e3e4e5e6e7e8e9ea"
    "f1f2f3f4f5f6f7f8f9faffda0008010100003f00f9debfffd9";

std::vector<Bytes> jpegs() {
  Bytes bytes;
  for (std::size_t i = 0; i < grey_jpeg.size(); i += 2) {
    bytes.push_back(
        static_cast<std::uint8_t>(std::stoi(std::string(grey_jpeg.substr(i, 2)), nullptr, 16)));
  }
  return {bytes};
}

/// Bytes of one that is unpacked, a few times over, and of the largest picture.
constexpr std::uint64_t bytes_of_png = 10'000, bytes_of_tiff = 40'000;
constexpr std::uint64_t bytes_of_largest = std::uint64_t{4} << 30;

bool add_picture_target(const std::string& ending, std::uint64_t bytes_each,
                        std::uint64_t bytes_besides = 64 << 20) {
  return add_fuzz_target({"frame" + ending, [=] { return pictures(ending); },
                          [=](std::span<const std::uint8_t> input) {
                            (void)read_frames({file_of(input, "frame" + ending)});
                          }},
                         bytes_each, bytes_besides);
}

template <class Number>
Number number_at(const Bytes& bytes, std::size_t at) {
  Number number{};
  std::memcpy(&number, bytes.data() + at, sizeof(number));
  return number;
}

/// Puts the checksum of so many bytes from `first` on.
void put_checksum(Bytes& bytes, std::size_t at, std::size_t first, std::size_t length,
                  std::uint32_t before = 0) {
  const std::uint32_t sum = checksum(std::span(bytes).subspan(first, length), before);
  std::memcpy(bytes.data() + at, &sum, sizeof(sum));
}

/// With checksums that are right again: what they keep out is let in.
Bytes repaired_png(std::span<const std::uint8_t> input) {
  Bytes bytes(input.begin(), input.end());
  constexpr std::size_t signature = 8, around = 12;  // length, kind and checksum of a chunk
  for (std::size_t at = signature; at + around <= bytes.size();) {
    const std::size_t length = __builtin_bswap32(number_at<std::uint32_t>(bytes, at));
    const std::size_t sum = at + 8 + length;
    if (length > bytes.size() - at - around) break;
    put_checksum(bytes, sum, at + 4, 4 + length);
    std::reverse(bytes.begin() + static_cast<std::ptrdiff_t>(sum),
                 bytes.begin() + static_cast<std::ptrdiff_t>(sum + 4));
    at += around + length;
  }
  return bytes;
}

/// Likewise; the layout is in docs/reference/clouds-and-recordings.md.
Bytes repaired_recording(std::span<const std::uint8_t> input) {
  Bytes bytes(input.begin(), input.end());
  constexpr std::size_t head = 64, sum = 60, end_mark = 16;
  if (bytes.size() < head) return bytes;
  const std::size_t begin = number_at<std::uint32_t>(bytes, 12);
  const std::uint64_t record = number_at<std::uint64_t>(bytes, 48);
  if (begin < head || begin > bytes.size() || record < head) return bytes;
  put_checksum(bytes, sum, head, begin - head, checksum(std::span(bytes).first(sum)));
  std::size_t at = begin;
  for (; record <= bytes.size() - at; at += record) put_checksum(bytes, at, at + 4, record - 4);
  if (bytes.size() - at == end_mark) put_checksum(bytes, at, at + 4, end_mark - 4);
  return bytes;
}

std::vector<Bytes> number_files() {
  const auto written = [](const auto& map) {
    return written_file("map.npy", [&](const fs::path& path) { write_map(path, map); });
  };
  return {written(Image<float>({5, 4}, 0.5F)), written(Image<double>({3, 7}, -2))};
}

std::vector<Bytes> height_files() {
  Image<HeightCurve> curves({3, 2});
  curves(2, 1) = {.reference = 0.25F, .slope = 1e-3F, .bend = -2e-4F, .lowest = 0, .highest = 0.5F};
  return {written_file("heights.npy",
                       [&](const fs::path& path) { write_height_curves(path, curves); })};
}

std::vector<Bytes> recordings() {
  std::vector<Bytes> seeds;
  for (const int bits : {8, 12}) {
    seeds.push_back(written_file("frames.recording", [&](const fs::path& path) {
      const FrameFormat format{{7, 5}, bits};
      RecordingHeader header{.format = format, .sequence = Sequence{.strategy = DualFrequency{}}};
      header.in_colour = bits == 12;
      if (header.in_colour) {
        header.white = frame_set_of({some_frame(7, format), some_frame(8, format), Frame(format)});
      }
      RecordingWriter writer(path, header);
      for (int i = 0; i < 3; ++i) writer.append(some_frame(i, format));
      writer.finish();
    }));
  }
  return seeds;
}

void read_recording(std::span<const std::uint8_t> input) {
  const RecordingReader reader(file_of(input, "input.recording"));
  Frame frame;
  for (std::uint64_t i = 0; i < std::min<std::uint64_t>(reader.count(), 8); ++i) {
    (void)reader.read(i, frame);
  }
}

/// A packet's pixels in each layout, fewer or more than the frame has.
void unpack_pixels(std::span<const std::uint8_t> input) {
  InputNumbers numbers(input);
  const auto names = pixel_format_names();
  const PixelFormat format = pixel_format_named(
      names[static_cast<std::size_t>(numbers.below(static_cast<int>(names.size())))]);
  Frame frame({{1 + numbers.below(40), 1 + numbers.below(40)}, bits_of(format)});
  const std::size_t needed = bytes_of(
      format, std::visit([](const auto& image) { return image.pixel_count(); }, frame.pixels));
  if (unpack(format, numbers.rest(), frame) != (numbers.rest().size() >= needed)) {
    throw std::logic_error("unpacked from too few bytes, or not from enough");
  }
}

const bool knows_picture_targets =
    add_picture_target(".png", bytes_of_png) && add_picture_target(".pgm", 1000) &&
    add_picture_target(".bmp", 1000) &&
    add_picture_target(".tiff", bytes_of_tiff, bytes_of_largest) &&
    add_fuzz_target(
        {"frame.jpg", jpegs,
         [](std::span<const std::uint8_t> input) { (void)read_frames({file_of(input, "f.jpg")}); }},
        1000, bytes_of_largest) &&
    add_fuzz_target(
        {"map.npy", number_files,
         [](std::span<const std::uint8_t> input) { (void)read_map(file_of(input, "map.npy")); }}) &&
    add_fuzz_target({"heights.npy", height_files,
                     [](std::span<const std::uint8_t> input) {
                       (void)read_height_curves(file_of(input, "heights.npy"));
                     }}) &&
    add_fuzz_target({"recording", recordings, read_recording}) &&
    add_fuzz_target(
        {"recording.repaired", recordings,
         [](std::span<const std::uint8_t> input) { read_recording(repaired_recording(input)); }}) &&
    add_fuzz_target({"frame.png.repaired", [] { return pictures(".png"); },
                     [](std::span<const std::uint8_t> input) {
                       (void)read_frames({file_of(repaired_png(input), "frame.png")});
                     }},
                    bytes_of_png) &&
    add_fuzz_target({"pixels", [] { return std::vector<Bytes>{Bytes(400, 0xa5)}; }, unpack_pixels});

}  // namespace
}  // namespace slipstream
