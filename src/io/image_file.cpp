#include "io/image_file.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <variant>
#include <vector>

#include "base/throw_if-inl.h"
#include "io/compressed_pictures.h"
#include "io/file.h"
#include "io/picture_file.h"
#include "io/pictures.h"
#include "io/plain_pictures.h"
#include "io/tiff_directories.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// The number of floats in a HeightCurve.
constexpr int members = sizeof(HeightCurve) / sizeof(float);

/// The pages of a TIFF file; empty for other endings and unreadable files. Throws Error if there
/// are too many.
std::vector<int> pages_in(const fs::path& path) {
  const std::string ending = lower_case_extension(path);
  if (ending != ".tif" && ending != ".tiff") return {};

  std::shared_ptr<const TiffDirectories> directories;
  try {
    directories = tiff_directories(path, InputFile(path, largest_picture_file));
  } catch (const Error&) {
    return {};
  }

  throw_if(directories->too_many, "{}: {}", path.string(), directories->fault);
  return directories->fault.empty() ? directories->pages : std::vector<int>();
}

using PictureWriter = std::vector<std::uint8_t> (*)(const PictureView& picture);

constexpr std::array<std::pair<std::string_view, PictureWriter>, 5> picture_writers{
    {{".png", png_file_of},
     {".tif", tiff_file_of},
     {".tiff", tiff_file_of},
     {".bmp", bmp_file_of},
     {".pgm", pgm_file_of}}};

/// Null if unsupported.
PictureWriter writer_of(std::string_view extension) {
  for (const auto& [ending, writer] : picture_writers) {
    if (ending == extension) return writer;
  }
  return nullptr;
}

/// The samples of a colour picture.
PictureView view_of_colours(const Image<Colour>& image) {
  static_assert(sizeof(Colour) == 3);
  const ImageView<const std::uint8_t> samples(reinterpret_cast<const std::uint8_t*>(image.begin()),
                                              {3 * image.width(), image.height()});
  return PictureView(samples, 3);
}

void write_picture(const fs::path& path, const PictureView& picture) {
  const std::string extension = lower_case_extension(path);
  const PictureWriter writer = writer_of(extension);
  throw_if(writer == nullptr,
           "{}: cannot write pictures with the ending '{}'; use .png, .tiff, .bmp or .pgm",
           path.string(), extension);
  const std::vector<std::uint8_t> bytes = writer(picture);

  throw_if(bytes.empty(), "{}: a {} file does not support such pixels; use .tiff", path.string(),
           extension);

  write_file(path, bytes);
}

bool is_npy(const fs::path& path) {
  return lower_case_extension(path) == ".npy";
}

/// Reads a map, or a picture's levels.
Picture read_map_picture(const fs::path& path) {
  if (!is_npy(path)) return read_picture(path);
  return naming(path.string(), [&] { return read_npy(read_file(path, largest_picture_file)); });
}

Image<double> wide_image(const Picture& picture) {
  return std::visit([](const auto& samples) { return converted<double>(samples); },
                    picture.samples);
}

std::string in_base64(const std::vector<std::uint8_t>& bytes) {
  constexpr std::string_view digits =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

  std::string text;

  // Three bytes become four digits of six bits each.
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const auto byte = [&](std::size_t k) { return i + k < bytes.size() ? bytes[i + k] : 0U; };
    const unsigned three = byte(0) << 16 | byte(1) << 8 | byte(2);
    for (const int shift : {18, 12, 6, 0}) text += digits[three >> shift & 63];
  }

  // The last group is filled up with zeros, whose digits are replaced by =.
  const std::size_t missing = (3 - bytes.size() % 3) % 3;
  return text.replace(text.size() - missing, missing, missing, '=');
}

}  // namespace

bool is_image_file(const fs::path& path) {
  return writer_of(lower_case_extension(path)) != nullptr;
}

bool is_jpeg_file(const fs::path& path) {
  const std::string ending = lower_case_extension(path);
  return ending == ".jpg" || ending == ".jpeg";
}

std::vector<fs::path> with_pages(const std::vector<fs::path>& paths) {
  std::vector<fs::path> all;
  for (const fs::path& path : paths) {
    const std::vector<int> pages = pages_in(path);
    if (pages.size() < 2) {
      all.push_back(path);
      continue;
    }

    for (const int page : pages) all.emplace_back(fmt::format("{}[{}]", path.string(), page));
  }
  return all;
}

fs::path file_of_page(const fs::path& path) {
  return place_of(path).file;
}

void write_image(const fs::path& path, const Image<std::uint8_t>& image) {
  write_picture(path, image);
}

void write_image(const fs::path& path, const Image<std::uint16_t>& image) {
  write_picture(path, image);
}

void write_image(const fs::path& path, const Image<Colour>& image) {
  write_picture(path, view_of_colours(image));
}

void write_page(const fs::path& path, const Page& page, PageFiles files) {
  const fs::path folder = fs::absolute(path).parent_path();
  make_folder(folder);

  // The PNG files of the pictures with pixels.
  std::map<std::string, std::vector<std::uint8_t>> drawn;
  for (const auto& [file, picture] : page.drawn()) {
    drawn[file] = png_file_of(view_of_colours(picture));
    if (files == PageFiles::with_pictures) write_file(folder / file, drawn[file]);
  }

  // Embeds the pictures, so that the page can be moved alone.
  std::string text = page.text();
  for (const std::string& file : page.files()) {
    const std::string source = "src=\"" + file + '"';
    const std::string inside =
        "src=\"data:image/png;base64," +
        in_base64(drawn.contains(file) ? drawn[file] : read_file(folder / file));
    const auto at = text.find(source);
    if (at != std::string::npos) text.replace(at, source.size(), inside + '"');
  }

  write_file(path, text);
}

void write_one_bit_image(const fs::path& path, const Image<std::uint8_t>& image) {
  write_file(path, one_bit_png_file_of(image));
}

void require_map_ending(const fs::path& path) {
  require_ending(path, "map", {".tif", ".tiff", ".npy"});
}

void write_map(const fs::path& path, const Image<float>& map) {
  require_map_ending(path);
  if (is_npy(path)) {
    write_file(path, npy_file_of(map));
  } else {
    write_picture(path, map);
  }
}

void write_map(const fs::path& path, const Image<double>& map) {
  require_map_ending(path);
  if (is_npy(path)) {
    write_file(path, npy_file_of(map));
  } else {
    write_map(path, converted<float>(map));
  }
}

Image<double> read_map(const fs::path& path) {
  const Picture picture = read_map_picture(path);
  if (picture.kind.real()) return wide_image(picture);
  throw Error(fmt::format("{}: not a map; expected a TIFF file of 32-bit float", path.string()));
}

Image<double> read_levels(const fs::path& path) {
  const Picture picture = read_map_picture(path);
  throw_if(picture.lossy, "{}: a JPEG, which alters levels; use PNG or TIFF", path.string());
  if (picture.kind.channels == 1) return wide_image(picture);
  throw Error(fmt::format("{}: a colour picture; expected a grey one or a map", path.string()));
}

void write_height_curves(const fs::path& path, const Image<HeightCurve>& curves) {
  require_ending(path, "height calibration", {".npy"});
  const ImageView<const float> numbers(reinterpret_cast<const float*>(curves.begin()),
                                       {members * curves.width(), curves.height()});
  write_file(path, npy_file_of(PictureView(numbers)));
}

Image<HeightCurve> read_height_curves(const fs::path& path) {
  require_ending(path, "height calibration", {".npy"});
  const auto numbers = converted<float>(read_map(path));

  return naming(path.string(), [&] {
    if (numbers.width() % members != 0) throw Error("expected five numbers for each pixel");

    Image<HeightCurve> curves({numbers.width() / members, numbers.height()});
    std::copy(numbers.begin(), numbers.end(), reinterpret_cast<float*>(curves.begin()));
    require_valid(curves);
    return curves;
  });
}

void write_frames(const std::vector<fs::path>& paths, const FrameViews& frames) {
  frames.visit([&](const auto& views) {
    for (std::size_t n = 0; n < paths.size(); ++n) write_picture(paths[n], PictureView(views[n]));
  });
}

void write_colour_frames(const std::vector<fs::path>& paths, const FrameViews& frames) {
  frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    const auto [width, height] = frames.size();
    Image<Pixel> samples({3 * width, height}, uninitialised);

    for (std::size_t n = 0; n < paths.size(); ++n) {
      for_each_pixel_in_order(samples.size(), [&](int i, int row) {
        // Column i holds channel i % 3 of pixel i / 3.
        samples(i, row) = views[3 * n + static_cast<std::size_t>(i % 3)](i / 3, row);
      });
      write_picture(paths[n], PictureView(ImageView<const Pixel>(samples), 3));
    }
  });
}

void require_colour_ending(const fs::path& path) {
  require_ending(path, "colour picture format", {".png", ".tif", ".tiff", ".bmp"});
}

}  // namespace slipstream
