#include "slipstream/io/image_file.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <variant>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "slipstream/base/error.h"
#include "slipstream/base/parallel_rows.h"
#include "slipstream/io/detail/npy_file.h"
#include "slipstream/io/detail/picture_size.h"
#include "slipstream/io/detail/plain_pictures.h"
#include "slipstream/io/detail/png_file.h"
#include "slipstream/io/detail/tiff_file.h"
#include "slipstream/io/file.h"
#include "slipstream/io/mat.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

using Bytes = std::span<const std::uint8_t>;

constexpr std::array<std::string_view, 5> image_extensions{".png", ".tif", ".tiff", ".bmp", ".pgm"};

/// A frame's pixels: grey levels, or unquantised.
using FrameImage = std::variant<Image<std::uint8_t>, Image<std::uint16_t>, Image<double>>;

/// Of a file that begins as one of the kinds that stated_pixels knows.
cv::Mat decoded(Bytes bytes) {
  if (is_png(bytes)) return read_png(bytes);
  if (bytes[0] == 'B') return read_bmp(bytes);
  return bytes[0] == 'P' ? read_pgm(bytes) : read_tiff(bytes);
}

/// What `decode` makes of the bytes of a picture's file, one of so many of a scan.
template <class Decode>
auto read_picture(const fs::path& path, std::size_t count, const Decode& decode) {
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
  const auto pixels = stated_pixels(bytes);
  if (!pixels) refuse("not a picture; a whole PNG, TIFF, BMP or PGM file is wanted");
  if (*pixels > largest_picture) {
    refuse(
        fmt::format("says that it has {} pixels; at most {} are read", *pixels, largest_picture));
  }
  require_scan_fits(count, std::max<std::uint64_t>(*pixels, 1), path);
  try {
    return decode(Bytes(bytes));
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", path.string(), error.what()));
  }
}

cv::Mat read_mat(const fs::path& path, std::size_t count = 1) {
  return read_picture(path, count, decoded);
}

FrameImage frame_image(const cv::Mat& mat) {
  if (mat.type() == CV_8UC1) return image_from<std::uint8_t>(mat);
  if (mat.type() == CV_16UC1) return image_from<std::uint16_t>(mat);
  if (mat.type() == CV_64FC1) return image_from<double>(mat);
  throw Error("pixels of an unknown kind; frames are grey, 8 or 16 bits");
}

FrameImage read_grey(const fs::path& path, std::size_t count, std::vector<std::string>& warnings) {
  return read_picture(path, count, [&](Bytes bytes) -> FrameImage {
    if (auto plain = is_png(bytes) ? read_plain_grey(bytes) : std::nullopt) {
      return std::visit([](auto& image) { return FrameImage(std::move(image)); }, *plain);
    }
    const cv::Mat mat = decoded(bytes);
    if (mat.channels() < 3 || mat.depth() > CV_16U) return frame_image(mat);
    warnings.push_back(fmt::format("{}: a colour picture, converted to grey", path.string()));
    cv::Mat grey;
    cv::cvtColor(mat, grey, mat.channels() == 4 ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
    return frame_image(grey);
  });
}

/// Red, green and blue.
std::vector<FrameImage> read_channels(const fs::path& path, std::size_t count) {
  const cv::Mat mat = read_mat(path, count);
  if (mat.channels() < 3 || mat.depth() > CV_16U) {
    throw Error(
        fmt::format("{}: a grey picture; as few as these would have to be in colour, with a "
                    "frame in each channel",
                    path.string()));
  }
  std::vector<cv::Mat> channels;  // blue first, as OpenCV has them
  cv::split(mat, channels);
  return {frame_image(channels[2]), frame_image(channels[1]), frame_image(channels[0])};
}

/// As a file of that ending; empty where such a file does not hold such pixels.
std::vector<std::uint8_t> encoded(const std::string& extension, const cv::Mat& mat) {
  if (extension == ".bmp") return bmp_file_of(mat);
  if (extension == ".pgm") return pgm_file_of(mat);
  if (extension != ".png") return tiff_file_of(mat);
  return mat.depth() == CV_8U || mat.depth() == CV_16U ? png_file_of(mat)
                                                       : std::vector<std::uint8_t>{};
}

void write_mat(const fs::path& path, const cv::Mat& mat) {
  const std::string extension = lower_case_extension(path);
  if (!is_image_file(path)) {
    throw Error(
        fmt::format("{}: no picture format has the ending '{}'; use .png, .tiff, .bmp or "
                    ".pgm",
                    path.string(), extension));
  }
  const std::vector<std::uint8_t> bytes = encoded(extension, mat);
  if (bytes.empty()) {
    throw Error(fmt::format("{}: a {} file does not hold such pixels; use .tiff", path.string(),
                            extension));
  }
  write_file(path, bytes);
}

bool is_npy(const fs::path& path) {
  return lower_case_extension(path) == ".npy";
}

void write_map_mat(const fs::path& path, const cv::Mat& mat) {
  if (is_npy(path)) return write_file(path, npy_file_of(mat));
  cv::Mat single;
  mat.convertTo(single, CV_32F);
  write_mat(path, single);
}

/// Of a map, or of a picture.
cv::Mat read_map_mat(const fs::path& path) {
  if (!is_npy(path)) return read_mat(path);
  try {
    return read_npy(read_file(path, largest_picture_file));
  } catch (const Error& error) {
    throw Error(fmt::format("{}: {}", path.string(), error.what()));
  }
}

Image<double> wide_image(const cv::Mat& mat) {
  cv::Mat wide;
  mat.convertTo(wide, CV_64F);
  return image_from<double>(wide);
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
  write_mat(path, mat_of(image));
}

void write_image(const fs::path& path, const Image<std::uint16_t>& image) {
  write_mat(path, mat_of(image));
}

void write_one_bit_image(const fs::path& path, const Image<std::uint8_t>& image) {
  write_file(path, one_bit_png_file_of(mat_of(image)));
}

void write_image(const fs::path& path, const Image<Colour>& image) {
  static_assert(sizeof(Colour) == 3);
  // cv::Mat has no const form.
  const cv::Mat colours(image.height(), image.width(), CV_8UC3, const_cast<Colour*>(image.row(0)));
  cv::Mat turned;
  cv::cvtColor(colours, turned, cv::COLOR_RGB2BGR);
  write_mat(path, turned);
}

std::vector<std::uint8_t> png_file(const Image<std::uint8_t>& image) {
  return png_file_of(mat_of(image));
}

void require_map_ending(const fs::path& path) {
  require_ending(path, "map", {".tif", ".tiff", ".npy"});
}

void write_map(const fs::path& path, const Image<float>& map) {
  require_map_ending(path);
  write_map_mat(path, mat_of(map));
}

void write_map(const fs::path& path, const Image<double>& map) {
  require_map_ending(path);
  write_map_mat(path, mat_of(map));
}

Image<double> read_map(const fs::path& path) {
  const cv::Mat mat = read_map_mat(path);
  if (mat.type() != CV_32FC1 && mat.type() != CV_64FC1) {
    throw Error(fmt::format("{}: not a map; a TIFF file of 32-bit float is wanted", path.string()));
  }
  return wide_image(mat);
}

Image<double> read_levels(const fs::path& path) {
  const cv::Mat mat = read_map_mat(path);
  if (mat.channels() == 1) return wide_image(mat);
  throw Error(fmt::format("{}: a colour picture; a grey one or a map is wanted", path.string()));
}

void write_frames(const std::vector<fs::path>& paths, const FrameViews& frames) {
  frames.visit([&](const auto& views) {
    for (std::size_t n = 0; n < paths.size(); ++n) write_mat(paths[n], mat_of(views[n]));
  });
}

void write_colour_frames(const std::vector<fs::path>& paths, const FrameViews& frames) {
  frames.visit([&](const auto& views) {
    for (std::size_t n = 0; n < paths.size(); ++n) {
      const std::vector<cv::Mat> channels{mat_of(views[3 * n + 2]), mat_of(views[3 * n + 1]),
                                          mat_of(views[3 * n])};
      cv::Mat picture;
      cv::merge(channels, picture);
      write_mat(paths[n], picture);
    }
  });
}

void require_colour_ending(const std::filesystem::path& path) {
  require_ending(path, "picture in colour", {".png", ".tif", ".tiff", ".bmp"});
}

}  // namespace slipstream
