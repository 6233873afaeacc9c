#include "slipstream/io/image_file.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <exception>
#include <string_view>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "slipstream/error/error.h"
#include "slipstream/image/parallel_rows.h"
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

constexpr std::array<std::string_view, 5> image_extensions{".png", ".tif", ".tiff", ".bmp", ".pgm"};

/// Of a file that begins as one of the kinds that stated_pixels knows.
cv::Mat decoded(const std::vector<std::uint8_t>& bytes) {
  if (is_png(bytes)) return read_png(bytes);
  if (bytes[0] == 'B') return read_bmp(bytes);
  return bytes[0] == 'P' ? read_pgm(bytes) : read_tiff(bytes);
}

/// One of so many frames of a scan, or a map.
cv::Mat read_mat(const fs::path& path, std::size_t frames = 1) {
  const std::vector<std::uint8_t> bytes = read_file(path, largest_picture_file);
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
  require_scan_fits(frames, std::max<std::uint64_t>(*pixels, 1), path);
  try {
    return decoded(bytes);
  } catch (const Error& error) {
    refuse(error.what());
  }
  return {};
}

cv::Mat read_grey_mat(const fs::path& path, std::size_t frames,
                      std::vector<std::string>& warnings) {
  cv::Mat mat = read_mat(path, frames);
  if (mat.channels() == 1) return mat;
  if (mat.channels() < 3 || mat.depth() > CV_16U) {
    throw Error(
        fmt::format("{}: pixels of an unknown kind; frames are grey, 8 or 16 bits", path.string()));
  }
  warnings.push_back(fmt::format("{}: a colour picture, converted to grey", path.string()));
  cv::Mat grey;
  cv::cvtColor(mat, grey, mat.channels() == 4 ? cv::COLOR_BGRA2GRAY : cv::COLOR_BGR2GRAY);
  return grey;
}

cv::Mat read_colour_mat(const fs::path& path, std::size_t frames) {
  cv::Mat mat = read_mat(path, frames);
  if (mat.channels() < 3 || mat.depth() > CV_16U) {
    throw Error(
        fmt::format("{}: a grey picture; as few as these would have to be in colour, with a "
                    "frame in each channel",
                    path.string()));
  }
  return mat;
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

template <class Pixel>
std::vector<Image<Pixel>> images_from(const std::vector<cv::Mat>& mats) {
  std::vector<Image<Pixel>> images;
  images.reserve(mats.size());
  for (const cv::Mat& mat : mats) images.push_back(image_from<Pixel>(mat));
  return images;
}

FrameSet frame_set_from(const std::vector<cv::Mat>& mats, int bits) {
  switch (mats.front().depth()) {
    case CV_8U:
      return FrameSet(images_from<std::uint8_t>(mats));
    case CV_16U:
      return {images_from<std::uint16_t>(mats), bits == 0 ? 16 : bits};
    default:
      return FrameSet(images_from<double>(mats));
  }
}

void require_like_first(const fs::path& path, const cv::Mat& mat, const fs::path& first_path,
                        const cv::Mat& first) {
  if (mat.size() != first.size()) {
    throw Error(fmt::format("{} is {}x{}, but {} is {}x{}; all frames of a scan have one size",
                            path.string(), mat.cols, mat.rows, first_path.string(), first.cols,
                            first.rows));
  }
  if (mat.depth() != first.depth()) {
    throw Error(fmt::format("{} and {} have different pixels; all frames of a scan have one kind",
                            path.string(), first_path.string()));
  }
}

/// A frame's pixels, or why there are none.
struct ReadFrame {
  cv::Mat mat;
  std::vector<std::string> warnings;
  std::exception_ptr failure;
};

/// On as many threads as there are.
std::vector<ReadFrame> read_at_once(const std::vector<fs::path>& paths, bool in_colour) {
  std::vector<ReadFrame> frames(paths.size());
  for_each_row(static_cast<int>(paths.size()), [&](int n) {
    const fs::path& path = paths[static_cast<std::size_t>(n)];
    auto& [mat, warnings, failure] = frames[static_cast<std::size_t>(n)];
    try {
      mat = in_colour ? read_colour_mat(path, paths.size())
                      : read_grey_mat(path, paths.size(), warnings);
      const int depth = mat.depth();
      if (depth != CV_8U && depth != CV_16U && depth != CV_64F) {
        throw Error(fmt::format("{}: pixels of an unknown kind; frames are grey, 8 or 16 bits",
                                path.string()));
      }
      require_scan_fits(paths.size(), mat.total() * mat.elemSize(), path);
    } catch (...) {
      mat.release();
      failure = std::current_exception();
    }
  });
  return frames;
}

/// Of all frames, in order, which are alike.
std::vector<cv::Mat> read_alike(const std::vector<fs::path>& paths, int bits, bool in_colour,
                                std::vector<std::string>& warnings) {
  std::vector<cv::Mat> mats;
  for (ReadFrame& frame : read_at_once(paths, in_colour)) {
    if (frame.failure) std::rethrow_exception(frame.failure);
    mats.push_back(std::move(frame.mat));
    warnings.insert(warnings.end(), frame.warnings.begin(), frame.warnings.end());
    require_like_first(paths[mats.size() - 1], mats.back(), paths.front(), mats.front());
  }
  if (bits > 8 && !mats.empty() && mats.front().depth() == CV_8U) {
    throw Error(fmt::format("{}: a picture of 8 bits, but the camera is said to have {}",
                            paths.front().string(), bits));
  }
  return mats;
}

}  // namespace

bool is_image_file(const fs::path& path) {
  const std::string extension = lower_case_extension(path);
  return std::find(image_extensions.begin(), image_extensions.end(), extension) !=
         image_extensions.end();
}

LoadedFrames read_frames(const std::vector<fs::path>& paths, int bits) {
  LoadedFrames loaded;
  const std::vector<cv::Mat> mats = read_alike(paths, bits, false, loaded.warnings);
  if (!mats.empty()) loaded.frames = frame_set_from(mats, bits);
  return loaded;
}

FrameSet read_colour_frames(const std::vector<fs::path>& paths, int bits) {
  std::vector<std::string> warnings;
  std::vector<cv::Mat> frames;
  for (const cv::Mat& picture : read_alike(paths, bits, true, warnings)) {
    std::vector<cv::Mat> channels;  // blue first, as OpenCV has them
    cv::split(picture, channels);
    for (const std::size_t channel : {2, 1, 0}) frames.push_back(channels[channel]);
  }
  return frames.empty() ? FrameSet() : frame_set_from(frames, bits);
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
