#include "io/image_file.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdint>
#include <exception>
#include <iterator>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <system_error>
#include <type_traits>
#include <variant>
#include <vector>

#include "base/numbers.h"
#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"
#include "io/compressed_pictures.h"
#include "io/file.h"
#include "io/pictures.h"
#include "io/plain_pictures.h"
#include "io/tiff_directories.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

using namespace std::string_view_literals;
using Bytes = std::span<const std::uint8_t>;

/// The number of floats in a HeightCurve.
constexpr int members = sizeof(HeightCurve) / sizeof(float);

using ReadPicture = Picture (*)(Bytes bytes, std::size_t frames);

/// Readers by the files' first bytes.
constexpr std::array<std::pair<std::string_view, ReadPicture>, 4> picture_formats{
    {{"\x89PNG\r\n\x1a\n"sv, read_png},
     {"\xff\xd8\xff"sv, read_jpeg},
     {"BM"sv, read_bmp},
     {"P"sv, read_pgm}}};

/// Null if the bytes are not a picture.
ReadPicture reader_of(Bytes bytes) {
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  const auto* const format = std::ranges::find_if(
      picture_formats, [&](const auto& known) { return text.starts_with(known.first); });
  if (format == picture_formats.end()) return nullptr;

  // The first byte P alone is too little: a digit from 1 to 6 and a blank must follow.
  const bool is_pgm = text.size() > 2 && text[1] >= '1' && text[1] <= '6' &&
                      std::isspace(static_cast<unsigned char>(text[2])) != 0;

  return format->second == read_pgm && !is_pgm ? nullptr : format->second;
}

/// The first bytes of a TIFF file, which is read page by page.
bool is_tiff(const InputFile& file) {
  std::array<char, 4> first{};
  const bool read = file.size() > first.size() &&
                    file.read(0, {{reinterpret_cast<std::uint8_t*>(first.data()), first.size()}});

  // The byte order, II (little-endian) or MM, and then 42 ('*'), or 43 ('+') for BigTIFF.
  const std::string_view magic(first.data(), first.size());
  return read &&
         (magic == "II*\0"sv || magic == "II+\0"sv || magic == "MM\0*"sv || magic == "MM\0+"sv);
}

/// A picture's file, and its page if the path names one.
struct PicturePlace {
  fs::path file;
  std::optional<int> page{};
};

PicturePlace place_of(const fs::path& path) {
  const std::string text = path.string();
  const std::size_t bracket = text.rfind('[');
  std::error_code unknown;

  // A file whose name ends in brackets is that file.
  if (!text.ends_with(']') || bracket == text.npos || fs::exists(path, unknown)) return {path};

  const auto page =
      number_in<int>(std::string_view(text).substr(bracket + 1, text.size() - bracket - 2));

  return page && *page >= 0 ? PicturePlace{text.substr(0, bracket), page} : PicturePlace{path};
}

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

/// Reads one picture of a scan with `frames` pictures.
Picture read_picture(const fs::path& path, std::size_t frames = 1) {
  const auto [name, page] = place_of(path);
  const InputFile file(name, largest_picture_file);

  return naming(path.string(), [&, page = page] {
    if (is_tiff(file)) return read_tiff(file, *tiff_directories(name, file), page, frames);
    throw_if(page.has_value(), "{} is not a TIFF file, which alone has pages", name.string());

    const auto memory = std::make_unique_for_overwrite<std::uint8_t[]>(file.size());
    const std::span bytes(memory.get(), file.size());
    if (!file.read(0, {bytes})) throw Error("became shorter while it was read");

    const ReadPicture read = reader_of(bytes);
    if (read == nullptr)
      throw Error("not a picture; expected a complete PNG, TIFF, BMP, PGM or JPEG file");

    return read(bytes, frames);
  });
}

/// Applies `value` to the channels of each pixel of 8 or 16 bits; the result has the same bits.
template <class Value>
Picture each_pixel(const Picture& picture, const Value& value) {
  Picture pixels({picture.kind.size, 1, picture.kind.bits});
  pixels.used_bits = picture.used_bits;

  std::visit(
      [&]<class Sample>(Image<Sample>& image) {
        if constexpr (std::is_integral_v<Sample>) {
          const Sample* channels = std::get<Image<Sample>>(picture.samples).begin();
          for (Sample& pixel : image) {
            pixel = static_cast<Sample>(value(channels));
            channels += picture.kind.channels;
          }
        }
      },
      pixels.samples);

  return pixels;
}

/// A grey frame, or the red, green and blue frames of a colour picture. `count`: pictures of the
/// scan.
std::vector<Picture> frames_in(const fs::path& path, std::size_t count, bool in_colour,
                               std::vector<std::string>& warnings) {
  Picture picture = read_picture(path, count);
  const PictureKind kind = picture.kind;
  std::vector<Picture> frames;

  naming(path.string(), [&] {
    throw_if(in_colour && picture.lossy, "a JPEG, which blurs the colours; use PNG, TIFF or BMP");
    throw_if(in_colour && kind.channels < 3,
             "a grey picture; so few pictures must be in colour, with one frame in each channel");
    if (kind.bits == 32) throw Error("unsupported pixels; frames are grey of 8 or 16 bits");

    for (int channel = 0; in_colour && channel < 3; ++channel) {
      frames.push_back(each_pixel(picture, [&](const auto* rgb) { return rgb[channel]; }));
    }

    if (!in_colour && kind.channels > 1) {
      warnings.push_back(fmt::format("{}: a colour picture, converted to grey", path.string()));
      picture = each_pixel(picture, [](const auto* rgb) {  // the weights of ITU-R BT.601
        // 0.299, 0.587 and 0.114 in units of 2^-15, rounded by half a unit of the sum.
        constexpr std::uint32_t half = 1U << 14;
        return (9798U * rgb[0] + 19235U * rgb[1] + 3735U * rgb[2] + half) >> 15;
      });
    }

    if (!in_colour) frames.push_back(std::move(picture));

    require_scan_fits(count, frames.size() * frames.front().kind.row_bytes() *
                                 static_cast<std::size_t>(kind.size.height));
  });

  return frames;
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

FrameSet frame_set_from(std::vector<Picture> frames, int bits) {
  return std::visit(
      [&]<class Pixel>(const Image<Pixel>&) -> FrameSet {
        std::vector<Image<Pixel>> images;
        for (Picture& frame : frames) {
          images.push_back(std::get<Image<Pixel>>(std::move(frame.samples)));
        }

        if constexpr (!std::is_same_v<Pixel, float>) return {std::move(images), bits};
        return {};  // frames are never 32-bit float
      },
      frames.front().samples);
}

/// A picture's frames, or the error.
struct ReadFrames {
  std::vector<Picture> frames;
  std::vector<std::string> warnings;
  std::exception_ptr failure;
};

/// Reads pictures on all threads.
std::vector<ReadFrames> read_at_once(const std::vector<fs::path>& paths, bool in_colour) {
  std::vector<ReadFrames> pictures(paths.size());

  for_each_row(static_cast<int>(paths.size()), [&](int n) {
    const auto place = static_cast<std::size_t>(n);
    auto& [frames, warnings, failure] = pictures[place];

    try {
      frames = frames_in(paths[place], paths.size(), in_colour, warnings);
    } catch (...) {
      failure = std::current_exception();
    }
  });

  return pictures;
}

/// Reads all frames, in order; they must have one size and kind.
LoadedFrames read_alike(const std::vector<fs::path>& paths, int bits, bool in_colour) {
  LoadedFrames loaded;
  std::vector<Picture> frames;
  int used_bits = 0;

  std::vector<ReadFrames> pictures = read_at_once(paths, in_colour);
  for (std::size_t n = 0; n < paths.size(); ++n) {
    auto& [read, warnings, failure] = pictures[n];
    // The first failure in the order of the paths, whichever thread came first.
    if (failure) std::rethrow_exception(failure);

    std::move(read.begin(), read.end(), std::back_inserter(frames));
    loaded.warnings.insert(loaded.warnings.end(), warnings.begin(), warnings.end());

    const PictureKind &kind = frames.back().kind, &first = frames.front().kind;
    loaded.lossy += frames.back().lossy ? 1 : 0;
    used_bits = std::max(used_bits, frames.back().used_bits);

    throw_if(kind.size != first.size,
             "{} is {}, but {} is {}; all frames of a scan must have one size", paths[n].string(),
             text_of(kind.size), paths.front().string(), text_of(first.size));
    throw_if(kind.bits != first.bits,
             "{} and {} have different pixel types; a scan must have one type", paths[n].string(),
             paths.front().string());
  }

  if (frames.empty()) return loaded;
  throw_if(bits > 8 && frames.front().kind.bits == 8,
           "{}: an 8-bit picture, but the camera bits are set to {}", paths.front().string(), bits);

  loaded.frames = frame_set_from(std::move(frames), bits == 0 ? used_bits : bits);
  return loaded;
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

LoadedFrames read_frames(const std::vector<fs::path>& paths, int bits) {
  return read_alike(paths, bits, false);
}

FrameSet read_colour_frames(const std::vector<fs::path>& paths, int bits) {
  return read_alike(paths, bits, true).frames;
}

void write_image(const fs::path& path, const Image<std::uint8_t>& image) {
  write_picture(path, image);
}

void write_image(const fs::path& path, const Image<std::uint16_t>& image) {
  write_picture(path, image);
}

void write_image(const fs::path& path, const Image<Colour>& image) {
  static_assert(sizeof(Colour) == 3);
  const ImageView<const std::uint8_t> samples(reinterpret_cast<const std::uint8_t*>(image.begin()),
                                              {3 * image.width(), image.height()});
  write_picture(path, PictureView(samples, 3));
}

void write_page(const fs::path& path, const Page& page) {
  const fs::path folder = fs::absolute(path).parent_path();
  make_folder(folder);

  for (const auto& [file, picture] : page.drawn()) write_image(folder / file, picture);

  // Embeds the pictures, so that the page can be moved alone.
  std::string text = page.text();
  for (const std::string& file : page.files()) {
    const std::string source = "src=\"" + file + '"';
    const std::string inside = "src=\"data:image/png;base64," + in_base64(read_file(folder / file));
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
  is_npy(path) ? write_file(path, npy_file_of(map)) : write_picture(path, map);
}

void write_map(const fs::path& path, const Image<double>& map) {
  require_map_ending(path);
  is_npy(path) ? write_file(path, npy_file_of(map)) : write_map(path, converted<float>(map));
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
