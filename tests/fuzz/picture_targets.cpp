// Frames: pictures, recordings, and pixels as cameras give them.
#include "slipstream/camera/pixel_format.h"
#include "slipstream/capture/scan_camera.h"
#include "slipstream/io/height_file.h"
#include "slipstream/io/image_file.h"
#include "slipstream/io/recording.h"
#include "slipstream/strategy/dual_frequency.h"
#include "tests/fuzz/target.h"
#include "tests/io/recorded_frames.h"

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

bool add_picture_target(const std::string& ending) {
  return add_fuzz_target({"frame" + ending, [=] { return pictures(ending); },
                          [=](std::span<const std::uint8_t> input) {
                            (void)read_frames({file_of(input, "frame" + ending)});
                          }});
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

const bool known =
    add_picture_target(".png") && add_picture_target(".pgm") && add_picture_target(".bmp") &&
    add_picture_target(".tiff") &&
    add_fuzz_target(
        {"map.npy", number_files,
         [](std::span<const std::uint8_t> input) { (void)read_map(file_of(input, "map.npy")); }}) &&
    add_fuzz_target({"heights.npy", height_files,
                     [](std::span<const std::uint8_t> input) {
                       (void)read_height_curves(file_of(input, "heights.npy"));
                     }}) &&
    add_fuzz_target({"recording", recordings, read_recording}) &&
    add_fuzz_target({"pixels", [] { return std::vector<Bytes>{Bytes(400, 0xa5)}; }, unpack_pixels});

}  // namespace
}  // namespace slipstream
