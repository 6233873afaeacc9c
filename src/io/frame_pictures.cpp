#include "io/frame_pictures.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <exception>
#include <iterator>
#include <string_view>
#include <type_traits>
#include <variant>

#include <fmt/ranges.h>

#include "base/names.h"
#include "base/parallel_rows.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "frames/mosaic.h"
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

/// Weights of red, green and blue in a grey level, in units of 2^-15.
using ChannelWeights = std::array<std::uint32_t, 3>;

ChannelWeights weights_of(GreyChannel channel) {
  constexpr std::uint32_t one = 1U << 15;
  switch (channel) {
    case GreyChannel::red:
      return {one, 0, 0};
    case GreyChannel::green:
      return {0, one, 0};
    case GreyChannel::blue:
      return {0, 0, one};
    default:
      return {9798, 19235, 3735};  // ITU-R BT.601: 0.299, 0.587 and 0.114
  }
}

/// Weighted mean of a pixel's channels, rounded by half a unit of the sum. At full scale if a
/// channel is that has a part in it, since its true level is unknown.
template <class Sample>
std::uint32_t weighted_level(const Sample* rgb, const ChannelWeights& weights,
                             std::uint32_t full_scale) {
  for (std::size_t c = 0; c < weights.size(); ++c) {
    if (weights[c] > 0 && rgb[c] >= full_scale) return full_scale;
  }

  constexpr std::uint32_t half = 1U << 14;
  return (weights[0] * rgb[0] + weights[1] * rgb[1] + weights[2] * rgb[2] + half) >> 15;
}

/// Levels of red, green, blue and grey at places spread over a picture; empty of a grey picture.
using ColourSamples = std::vector<std::array<double, 4>>;

ColourSamples colour_samples(const Picture& picture, std::uint32_t full_scale) {
  constexpr int places = 2048;
  const ChannelWeights weights = weights_of(GreyChannel::grey);
  const auto [width, height] = picture.kind.size;
  const int channels = picture.kind.channels;

  ColourSamples samples;
  std::visit(
      [&]<class Sample>(const Image<Sample>& image) {
        if constexpr (std::is_integral_v<Sample>) {
          for (int i = 0; i < places; ++i) {
            const auto [x, y] = spread_place(i);
            const Sample* const rgb =
                image.row(static_cast<int>(y * height)) + static_cast<int>(x * width) * channels;
            const double grey = weighted_level(rgb, weights, full_scale);
            samples.push_back({static_cast<double>(rgb[0]), static_cast<double>(rgb[1]),
                               static_cast<double>(rgb[2]), grey});
          }
        }
      },
      picture.samples);

  return samples;
}

/// The channel that measures best: whose levels change most from picture to picture and are not
/// saturated. A single one must be clearly better than grey, whose noise is that much less: the
/// root of the sum of its squared weights is 0.67. `bits`: of a sample.
GreyChannel best_channel(const std::vector<ColourSamples>& pictures, int bits) {
  constexpr double clearly = 1.5;
  const double full_scale = (1 << bits) - 1;
  const double least_range = 24.0 / 255 * full_scale;  // above noise

  std::array<double, 4> ranges{};
  for (std::size_t place = 0; place < pictures.front().size(); ++place) {
    std::array<double, 4> range{}, brightest{};

    for (std::size_t channel = 0; channel < range.size(); ++channel) {
      double least = pictures.front()[place][channel], greatest = least;
      for (const ColourSamples& picture : pictures) {
        least = std::min(least, picture[place][channel]);
        greatest = std::max(greatest, picture[place][channel]);
      }
      range[channel] = greatest - least;
      brightest[channel] = greatest;
    }

    // Dark places have only noise, and saturated ones no phase.
    if (*std::ranges::max_element(range) < least_range) continue;
    for (std::size_t channel = 0; channel < range.size(); ++channel) {
      if (brightest[channel] < full_scale) ranges[channel] += range[channel];
    }
  }

  const auto strongest = std::max_element(ranges.begin(), ranges.begin() + 3) - ranges.begin();
  if (ranges[strongest] <= clearly * ranges[3]) return GreyChannel::grey;

  constexpr std::array channels{GreyChannel::red, GreyChannel::green, GreyChannel::blue};
  return channels[strongest];
}

/// A picture's frames, or the error.
struct ReadFrames {
  std::vector<Picture> frames;
  ColourSamples samples;  ///< of a colour picture that became grey
  std::exception_ptr failure;
};

/// How the pictures of a scan are read.
struct ScanReading {
  std::size_t count = 0;  ///< of the pictures
  bool in_colour = false;
  FrameReading as{};
  ColourMean* mean = nullptr;  ///< of the pictures that show the colours; null: not wanted
};

/// The mosaic's grey levels, by the weights of make_grey.
Picture grey_of_mosaic(Picture raw, int bits) {
  Frame frame;
  frame.bits = bits;
  std::visit(
      [&]<class Sample>(Image<Sample>& image) {
        if constexpr (std::is_integral_v<Sample>) frame.pixels = std::move(image);
      },
      raw.samples);

  make_grey(frame);
  std::visit([&](auto& image) { raw.samples = std::move(image); }, frame.pixels);
  return raw;
}

/// Red, green and blue of a raw picture.
Picture in_three_channels(const Picture& raw, const std::string& mosaic) {
  Picture picture({raw.kind.size, 3, raw.kind.bits});
  picture.used_bits = raw.used_bits;
  std::visit(
      [&]<class Sample>(const Image<Sample>& image) {
        if constexpr (std::is_integral_v<Sample>) picture.samples = demosaiced(image, mosaic);
      },
      raw.samples);
  return picture;
}

/// The grey frame of a colour picture, or of a raw one.
void take_grey(Picture picture, const ScanReading& reading, bool shows_colour, ReadFrames& read) {
  const auto& [bits, channel, mosaic, of_colour] = reading.as;
  const int used_bits = bits != 0 ? bits : picture.used_bits;
  const auto full_scale = static_cast<std::uint32_t>((1 << used_bits) - 1);
  const bool is_raw = picture.kind.channels == 1;

  // 1. The colours; in a raw picture they are interpolated.
  const Picture rgb = is_raw ? in_three_channels(picture, mosaic) : std::move(picture);
  read.samples = colour_samples(rgb, full_scale);
  if (shows_colour && rgb.kind.channels == 3) {
    std::visit(
        [&]<class Sample>(const Image<Sample>& image) {
          if constexpr (std::is_integral_v<Sample>) reading.mean->add(image);
        },
        rgb.samples);
  }

  // 2. The grey levels.
  const bool is_grey = channel == GreyChannel::by_light || channel == GreyChannel::grey;
  if (is_raw && is_grey) {
    read.frames.push_back(grey_of_mosaic(std::move(picture), used_bits));
    return;
  }

  const ChannelWeights weights = weights_of(channel);
  read.frames.push_back(each_pixel(
      rgb, [&](const auto* levels) { return weighted_level(levels, weights, full_scale); }));
}

/// A grey frame, or the red, green and blue frames of a colour picture. `n`: index of the picture.
void take_frames(const fs::path& path, std::size_t n, const ScanReading& reading,
                 ReadFrames& read) {
  const std::size_t count = reading.count;
  const bool in_colour = reading.in_colour;
  const std::vector<bool>& of_colour = reading.as.of_colour;
  Picture picture = read_picture(path, count);
  const PictureKind kind = picture.kind;

  naming(path.string(), [&] {
    throw_if(in_colour && picture.lossy, "a JPEG, which blurs the colours; use PNG, TIFF or BMP");
    const bool is_raw = !reading.as.mosaic.empty() && kind.channels == 1;
    throw_if(is_raw && kind.real(), "real numbers; `mosaic` is for raw pictures of 8 or 16 bits");
    if (is_raw && in_colour) picture = in_three_channels(picture, reading.as.mosaic);

    throw_if(in_colour && picture.kind.channels < 3,
             "a grey picture; so few pictures must be in colour, with one frame in each channel");
    if (kind.bits == 32) picture = in_double(picture);

    for (int i = 0; in_colour && i < 3; ++i) {
      read.frames.push_back(each_pixel(picture, [&](const auto* rgb) { return rgb[i]; }));
    }

    if (!in_colour && (is_raw || kind.channels > 1)) {
      const bool shows_colour = reading.mean != nullptr && n < of_colour.size() && of_colour[n];
      take_grey(std::move(picture), reading, shows_colour, read);
    } else if (!in_colour) {
      read.frames.push_back(std::move(picture));
    }

    require_scan_fits(count, read.frames.size() * read.frames.front().kind.row_bytes() *
                                 static_cast<std::size_t>(kind.size.height));
  });
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

/// Reads pictures on all threads.
std::vector<ReadFrames> read_at_once(const std::vector<fs::path>& paths,
                                     const ScanReading& reading) {
  std::vector<ReadFrames> pictures(paths.size());

  for_each_row(static_cast<int>(paths.size()), [&](int n) {
    const auto place = static_cast<std::size_t>(n);
    try {
      take_frames(paths[place], place, reading, pictures[place]);
    } catch (...) {
      pictures[place].failure = std::current_exception();
    }
  });

  return pictures;
}

/// Reads colour pictures again by the channel that the light reaches, and says which became grey.
void choose_channel(const std::vector<fs::path>& paths, ScanReading reading,
                    std::vector<ReadFrames>& pictures, std::vector<std::string>& warnings) {
  std::vector<ColourSamples> samples;
  std::size_t first = paths.size();
  for (std::size_t n = 0; n < paths.size(); ++n) {
    if (pictures[n].failure || pictures[n].samples.empty()) continue;
    first = std::min(first, n);
    samples.push_back(std::move(pictures[n].samples));
  }
  if (samples.empty()) return;

  const std::string which = samples.size() == 1
                                ? fmt::format("{}: a colour picture", paths[first].string())
                                : fmt::format("{} and {} more colour pictures",
                                              paths[first].string(), samples.size() - 1);

  const Picture& picture = pictures[first].frames.front();
  const int bits = reading.as.bits != 0 ? reading.as.bits : picture.used_bits;
  const GreyChannel channel = best_channel(samples, bits);
  if (channel == GreyChannel::grey) {
    warnings.push_back(which + ", converted to grey, which measures best");
    return;
  }

  warnings.push_back(fmt::format(
      "{}, read by the {} channel, in which the light changes most; `channel` chooses another",
      which, name_of(channel)));
  reading.as.channel = channel;
  reading.mean = nullptr;  // known already
  pictures = read_at_once(paths, reading);
}

/// Reads all frames, in order; they must have one size and kind.
LoadedFrames read_alike(const std::vector<fs::path>& paths, bool in_colour,
                        const FrameReading& as) {
  int bits = as.bits;
  ColourMean mean;
  const ScanReading reading{.count = paths.size(), .in_colour = in_colour, .as = as, .mean = &mean};
  LoadedFrames loaded;
  std::vector<Picture> frames;
  int used_bits = 0;

  std::vector<ReadFrames> pictures = read_at_once(paths, reading);
  if (as.channel == GreyChannel::by_light) {
    choose_channel(paths, reading, pictures, loaded.warnings);
  }

  for (std::size_t n = 0; n < paths.size(); ++n) {
    auto& [read, samples, failure] = pictures[n];
    // The first failure in the order of the paths, whichever thread came first.
    if (failure) std::rethrow_exception(failure);

    std::move(read.begin(), read.end(), std::back_inserter(frames));

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
  loaded.colour = mean.levels(loaded.frames.full_scale());
  return loaded;
}

constexpr std::array<std::string_view, 5> channel_names{"auto", "grey", "red", "green", "blue"};

}  // namespace

std::string_view name_of(GreyChannel channel) {
  return channel_names.at(static_cast<std::size_t>(channel));
}

GreyChannel grey_channel_named(std::string_view name) {
  const auto found = value_named<GreyChannel>(name, channel_names);
  if (found) return *found;
  throw Error(
      fmt::format("channel '{}': expected one of: {}", name, fmt::join(channel_names, ", ")));
}

LoadedFrames read_frames(const std::vector<fs::path>& paths, const FrameReading& reading) {
  return read_alike(paths, false, reading);
}

LoadedFrames read_frames(const std::vector<fs::path>& paths, int bits, GreyChannel channel) {
  return read_alike(paths, false, {.bits = bits, .channel = channel});
}

FrameSet read_colour_frames(const std::vector<fs::path>& paths, int bits) {
  return read_alike(paths, true, {.bits = bits}).frames;
}

}  // namespace slipstream
