#include "slipstream/io/image_file.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <exception>
#include <iterator>
#include <memory>
#include <span>
#include <string_view>
#include <type_traits>
#include <utility>
#include <variant>

#include <fmt/format.h>

#include "slipstream/base/error.h"
#include "slipstream/base/image.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/io/detail/pictures.h"
#include "slipstream/io/file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

using namespace std::string_view_literals;
using Bytes = std::span<const std::uint8_t>;

constexpr std::array<std::string_view, 5> image_extensions{".png", ".tif", ".tiff", ".bmp", ".pgm"};

/// The numbers of a HeightCurve, as they stand in its memory.
constexpr int members = sizeof(HeightCurve) / sizeof(float);
using Members = std::array<float, members>;

/// A frame's pixels: grey levels, or unquantised.
using FrameImage = std::variant<Image<std::uint8_t>, Image<std::uint16_t>, Image<double>>;

struct PictureFormat {
  std::string_view start;  ///< of its files
  std::uint64_t (*stated_pixels)(Bytes bytes);
  Picture (*read)(Bytes bytes);
};

constexpr std::array<PictureFormat, 7> picture_formats{
    {{"\x89PNG\r\n\x1a\n"sv, png_pixels, read_png},
     {"II*\0"sv, tiff_pixels, read_tiff},
     {"II+\0"sv, tiff_pixels, read_tiff},
     {"MM\0*"sv, tiff_pixels, read_tiff},
     {"MM\0+"sv, tiff_pixels, read_tiff},
     {"BM"sv, bmp_pixels, read_bmp},
     {"P"sv, pgm_pixels, read_pgm}}};

/// Null where the bytes are of no picture.
const PictureFormat* format_of(Bytes bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto* const format =
      std::find_if(picture_formats.begin(), picture_formats.end(),
                   [&](const auto& known) { return text.starts_with(known.start); });
  if (format == picture_formats.end()) return nullptr;
  const bool is_pgm = text.size() > 2 && text[1] >= '1' && text[1] <= '6' &&
                      std::isspace(static_cast<unsigned char>(text[2])) != 0;
  return format->read == read_pgm && !is_pgm ? nullptr : format;
}

/// One of so many of a scan.
Picture read_picture(const fs::path& path, std::size_t count = 1) {
  const InputFile file(path, largest_picture_file);
  const auto memory = std::make_unique_for_overwrite<std::uint8_t[]>(file.size());
  const std::span bytes(memory.get(), file.size());
  if (!file.read(0, {bytes})) throw Error(fmt::format("{}: became shorter", path.string()));
  const auto refuse = [&](std::string_view why) {
    throw Error(fmt::format("{}: {}", path.string(), why));
  };
  if (bytes.size() > 2 && bytes[0] == 0xff && bytes[1] == 0xd8 && bytes[2] == 0xff) {
    refuse(
        "a JPEG, whose lossy compression spoils the phase; a PNG, TIFF, BMP or PGM file is "
        "wanted");
  }
  const PictureFormat* const format = format_of(bytes);
  if (format == nullptr) refuse("not a picture; a whole PNG, TIFF, BMP or PGM file is wanted");
  const std::uint64_t pixels = format->stated_pixels(bytes);
  if (pixels > largest_picture) {
    refuse(fmt::format("says that it has {} pixels; at most {} are read", pixels, largest_picture));
  }
  require_scan_fits(count, std::max<std::uint64_t>(pixels, 1), path);
  return naming(path.string(), [&] { return format->read(bytes); });
}

/// Throws Error where it is none.
FrameImage frame_image(Picture picture, const fs::path& path) {
  return std::visit(
      [&]<class Sample>(Image<Sample>& samples) -> FrameImage {
        if constexpr (!std::is_same_v<Sample, float>) return std::move(samples);
        throw Error(fmt::format("{}: pixels of an unknown kind; frames are grey, 8 or 16 bits",
                                path.string()));
      },
      picture.samples);
}

/// `value` of the channels of each pixel, in 8 or 16 bits as they are.
template <class Value>
FrameImage each_pixel(const Picture& picture, const Value& value) {
  return std::visit(
      [&]<class Sample>(const Image<Sample>& samples) -> FrameImage {
        if constexpr (std::is_integral_v<Sample>) {
          Image<Sample> image({samples.width() / picture.channels, samples.height()},
                              uninitialised);
          const Sample* channels = samples.begin();
          for (Sample& pixel : image) {
            pixel = static_cast<Sample>(value(channels));
            channels += picture.channels;
          }
          return image;
        }
        return {};  // float is grey
      },
      picture.samples);
}

FrameImage read_grey(const fs::path& path, std::size_t count, std::vector<std::string>& warnings) {
  Picture picture = read_picture(path, count);
  if (picture.channels == 1) return frame_image(std::move(picture), path);
  warnings.push_back(fmt::format("{}: a colour picture, converted to grey", path.string()));
  return each_pixel(picture, [](const auto* rgb) {  // the weights of ITU-R BT.601
    constexpr std::uint32_t half = 1U << 14;
    return (9798U * rgb[0] + 19235U * rgb[1] + 3735U * rgb[2] + half) >> 15;
  });
}

/// Red, green and blue.
std::vector<FrameImage> read_channels(const fs::path& path, std::size_t count) {
  const Picture picture = read_picture(path, count);
  if (picture.channels < 3) {
    throw Error(
        fmt::format("{}: a grey picture; as few as these would have to be in colour, with a "
                    "frame in each channel",
                    path.string()));
  }
  std::vector<FrameImage> frames;
  for (int channel = 0; channel < 3; ++channel) {
    frames.push_back(each_pixel(picture, [&](const auto* rgb) { return rgb[channel]; }));
  }
  return frames;
}

/// As a file of that ending; empty where such a file does not hold such pixels.
std::vector<std::uint8_t> encoded(const std::string& extension, const PictureView& picture) {
  if (extension == ".bmp") return bmp_file_of(picture);
  if (extension == ".pgm") return pgm_file_of(picture);
  return extension == ".png" ? png_file_of(picture) : tiff_file_of(picture);
}

void write_picture(const fs::path& path, const PictureView& picture) {
  const std::string extension = lower_case_extension(path);
  if (!is_image_file(path)) {
    throw Error(
        fmt::format("{}: no picture format has the ending '{}'; use .png, .tiff, .bmp or "
                    ".pgm",
                    path.string(), extension));
  }
  const std::vector<std::uint8_t> bytes = encoded(extension, picture);
  if (bytes.empty()) {
    throw Error(fmt::format("{}: a {} file does not hold such pixels; use .tiff", path.string(),
                            extension));
  }
  write_file(path, bytes);
}

template <class Pixel>
PictureView grey(const Image<Pixel>& image) {
  return {ImageView<const Pixel>(image)};
}

bool is_npy(const fs::path& path) {
  return lower_case_extension(path) == ".npy";
}

/// A map, or a picture's levels.
Picture read_map_picture(const fs::path& path) {
  if (!is_npy(path)) return read_picture(path);
  return naming(path.string(), [&] { return read_npy(read_file(path, largest_picture_file)); });
}

Image<double> wide_image(const Picture& picture) {
  return std::visit([](const auto& samples) { return converted<double>(samples); },
                    picture.samples);
}

FrameSet frame_set_from(std::vector<FrameImage> frames, int bits) {
  return std::visit(
      [&]<class Pixel>(const Image<Pixel>&) -> FrameSet {
        std::vector<Image<Pixel>> images;
        for (FrameImage& frame : frames) images.push_back(std::get<Image<Pixel>>(std::move(frame)));
        if constexpr (std::is_same_v<Pixel, std::uint16_t>) {
          return {std::move(images), bits == 0 ? 16 : bits};
        } else {
          return FrameSet(std::move(images));
        }
      },
      frames.front());
}

Size size_of(const FrameImage& frame) {
  return std::visit([](const auto& image) { return image.size(); }, frame);
}

std::size_t bytes_of(const FrameImage& frame) {
  return std::visit([](const auto& image) { return image.pixel_count() * sizeof(*image.begin()); },
                    frame);
}

void require_like_first(const fs::path& path, const FrameImage& frame, const fs::path& first_path,
                        const FrameImage& first) {
  if (size_of(frame) != size_of(first)) {
    throw Error(fmt::format("{} is {}, but {} is {}; all frames of a scan have one size",
                            path.string(), text_of(size_of(frame)), first_path.string(),
                            text_of(size_of(first))));
  }
  if (frame.index() != first.index()) {
    throw Error(fmt::format("{} and {} have different pixels; all frames of a scan have one kind",
                            path.string(), first_path.string()));
  }
}

/// A picture's frames, or why there are none.
struct ReadPicture {
  std::vector<FrameImage> frames;
  std::vector<std::string> warnings;
  std::exception_ptr failure;
};

/// On as many threads as there are.
std::vector<ReadPicture> read_at_once(const std::vector<fs::path>& paths, bool in_colour) {
  std::vector<ReadPicture> pictures(paths.size());
  for_each_row(static_cast<int>(paths.size()), [&](int n) {
    const fs::path& path = paths[static_cast<std::size_t>(n)];
    auto& [frames, warnings, failure] = pictures[static_cast<std::size_t>(n)];
    try {
      if (in_colour) {
        frames = read_channels(path, paths.size());
      } else {
        frames.push_back(read_grey(path, paths.size(), warnings));
      }
      require_scan_fits(paths.size(), frames.size() * bytes_of(frames.front()), path);
    } catch (...) {
      frames.clear();
      failure = std::current_exception();
    }
  });
  return pictures;
}

/// All frames, in order, which are alike.
FrameSet read_alike(const std::vector<fs::path>& paths, int bits, bool in_colour,
                    std::vector<std::string>& warnings) {
  std::vector<FrameImage> frames;
  std::vector<ReadPicture> pictures = read_at_once(paths, in_colour);
  for (std::size_t n = 0; n < paths.size(); ++n) {
    auto& [read, told, failure] = pictures[n];
    if (failure) std::rethrow_exception(failure);
    std::move(read.begin(), read.end(), std::back_inserter(frames));
    warnings.insert(warnings.end(), told.begin(), told.end());
    require_like_first(paths[n], frames.back(), paths.front(), frames.front());
  }
  if (frames.empty()) return {};
  if (bits > 8 && std::holds_alternative<Image<std::uint8_t>>(frames.front())) {
    throw Error(fmt::format("{}: a picture of 8 bits, but the camera is said to have {}",
                            paths.front().string(), bits));
  }
  return frame_set_from(std::move(frames), bits);
}

}  // namespace

bool is_image_file(const fs::path& path) {
  const std::string extension = lower_case_extension(path);
  return std::find(image_extensions.begin(), image_extensions.end(), extension) !=
         image_extensions.end();
}

LoadedFrames read_frames(const std::vector<fs::path>& paths, int bits) {
  LoadedFrames loaded;
  loaded.frames = read_alike(paths, bits, false, loaded.warnings);
  return loaded;
}

FrameSet read_colour_frames(const std::vector<fs::path>& paths, int bits) {
  std::vector<std::string> warnings;
  return read_alike(paths, bits, true, warnings);
}

void write_image(const fs::path& path, const Image<std::uint8_t>& image) {
  write_picture(path, grey(image));
}

void write_image(const fs::path& path, const Image<std::uint16_t>& image) {
  write_picture(path, grey(image));
}

void write_image(const fs::path& path, const Image<Colour>& image) {
  static_assert(sizeof(Colour) == 3);
  const ImageView<const std::uint8_t> samples(reinterpret_cast<const std::uint8_t*>(image.begin()),
                                              {3 * image.width(), image.height()});
  write_picture(path, {samples, 3});
}

void write_one_bit_image(const fs::path& path, const Image<std::uint8_t>& image) {
  write_file(path, one_bit_png_file_of(image));
}

std::vector<std::uint8_t> png_file(const Image<std::uint8_t>& image) {
  return png_file_of(grey(image));
}

void require_map_ending(const fs::path& path) {
  require_ending(path, "map", {".tif", ".tiff", ".npy"});
}

void write_map(const fs::path& path, const Image<float>& map) {
  require_map_ending(path);
  is_npy(path) ? write_file(path, npy_file_of(grey(map))) : write_picture(path, grey(map));
}

void write_map(const fs::path& path, const Image<double>& map) {
  require_map_ending(path);
  is_npy(path) ? write_file(path, npy_file_of(grey(map))) : write_map(path, converted<float>(map));
}

Image<double> read_map(const fs::path& path) {
  const Picture picture = read_map_picture(path);
  const bool real = std::holds_alternative<Image<float>>(picture.samples) ||
                    std::holds_alternative<Image<double>>(picture.samples);
  if (real) return wide_image(picture);
  throw Error(fmt::format("{}: not a map; a TIFF file of 32-bit float is wanted", path.string()));
}

Image<double> read_levels(const fs::path& path) {
  const Picture picture = read_map_picture(path);
  if (picture.channels == 1) return wide_image(picture);
  throw Error(fmt::format("{}: a colour picture; a grey one or a map is wanted", path.string()));
}

void write_height_curves(const fs::path& path, const Image<HeightCurve>& curves) {
  require_ending(path, "calibration of heights", {".npy"});
  Image<float> numbers({members * curves.width(), curves.height()});
  float* to = numbers.begin();
  for (const HeightCurve& curve : curves)
    to = std::ranges::copy(std::bit_cast<Members>(curve), to).out;
  write_map(path, numbers);
}

Image<HeightCurve> read_height_curves(const fs::path& path) {
  require_ending(path, "calibration of heights", {".npy"});
  const Image<double> numbers = read_map(path);
  return naming(path.string(), [&] {
    if (numbers.width() % members != 0) throw Error("five numbers for each pixel are wanted");
    Image<HeightCurve> curves({numbers.width() / members, numbers.height()});
    const double* from = numbers.begin();
    for (HeightCurve& curve : curves) {
      Members row{};
      for (float& member : row) member = static_cast<float>(*from++);
      curve = std::bit_cast<HeightCurve>(row);
    }
    require_valid(curves);
    return curves;
  });
}

void write_frames(const std::vector<fs::path>& paths, const FrameViews& frames) {
  frames.visit([&](const auto& views) {
    for (std::size_t n = 0; n < paths.size(); ++n) write_picture(paths[n], {views[n]});
  });
}

void write_colour_frames(const std::vector<fs::path>& paths, const FrameViews& frames) {
  frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    const auto [width, height] = frames.size();
    Image<Pixel> samples({3 * width, height}, uninitialised);
    for (std::size_t n = 0; n < paths.size(); ++n) {
      for (int row = 0; row < height; ++row) {
        for (int i = 0; i < 3 * width; ++i) {
          samples(i, row) = views[3 * n + static_cast<std::size_t>(i % 3)](i / 3, row);
        }
      }
      write_picture(paths[n], {ImageView<const Pixel>(samples), 3});
    }
  });
}

void require_colour_ending(const fs::path& path) {
  require_ending(path, "picture in colour", {".png", ".tif", ".tiff", ".bmp"});
}

}  // namespace slipstream
