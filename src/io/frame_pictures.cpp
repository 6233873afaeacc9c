#include "io/frame_pictures.h"

#include <algorithm>
#include <cstdint>
#include <exception>
#include <iterator>
#include <type_traits>
#include <variant>

#include "base/parallel_rows.h"
#include "base/throw_if-inl.h"
#include "io/file.h"
#include "io/picture_file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

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

Picture in_double(const Picture& picture) {
  Picture wide({picture.kind.size, picture.kind.channels, 64});
  wide.samples =
      std::visit([](const auto& samples) { return converted<double>(samples); }, picture.samples);
  return wide;
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
    if (kind.bits == 32) picture = in_double(picture);

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

/// Scales unquantised frames to grey levels of 255, and says if it does so unasked. `bits`: of the
/// camera; 0 if unknown.
void scale_levels(std::vector<Picture>& frames, int bits, const fs::path& first,
                  std::vector<std::string>& warnings) {
  // Frames of grey levels this low have no pattern.
  constexpr double most_of_shares = 1.5;

  double brightest = 0;
  for (const Picture& frame : frames) {
    for (const double level : std::get<Image<double>>(frame.samples)) {
      brightest = std::max(brightest, level);  // ignores NaN
    }
  }

  double factor = bits > 8 ? 255.0 / ((1 << bits) - 1) : 1;
  if (bits == 0 && brightest > 0 && brightest <= most_of_shares) {
    factor = 255;
    warnings.push_back(fmt::format(
        "{}: frames of real numbers up to {:.3g}, read as shares of the brightest level",
        first.string(), brightest));
  }
  if (factor == 1) return;

  for (Picture& frame : frames) {
    for (double& level : std::get<Image<double>>(frame.samples)) level *= factor;
  }
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

  if (frames.front().kind.real()) {
    scale_levels(frames, bits, paths.front(), loaded.warnings);
    bits = 8;
  }

  loaded.frames = frame_set_from(std::move(frames), bits == 0 ? used_bits : bits);
  return loaded;
}

}  // namespace

LoadedFrames read_frames(const std::vector<fs::path>& paths, int bits) {
  return read_alike(paths, bits, false);
}

FrameSet read_colour_frames(const std::vector<fs::path>& paths, int bits) {
  return read_alike(paths, bits, true).frames;
}

}  // namespace slipstream
