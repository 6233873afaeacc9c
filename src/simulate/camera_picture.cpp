#include "simulate/camera_picture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "base/parallel_rows.h"
#include "io/plain_pictures.h"
#include "simulate/seen_scene.h"
#include "slipstream/error.h"

namespace slipstream {

#ifndef SLIPSTREAM_IO
void recompress_jpeg(Image<std::uint8_t>&, int, int) {
  throw Error("this build compresses no pictures (SLIPSTREAM_IO is off)");
}
#endif

namespace {

// Keys of random numbers that are constant over frames; no frame has these numbers.
constexpr std::uint64_t of_offsets = 0xfffff0, of_sensitivities = 0xfffff1, of_rows = 0x800000;

/// Gives each picture the gain that brings its mean nearer to a quarter of full scale, by a share
/// of the stops between them.
void expose_automatically(std::vector<Image<double>>& light, std::size_t channels, double share) {
  constexpr double wanted = 64, darkest = 1;  // grey levels

  for (std::size_t first = 0; first < light.size(); first += channels) {
    double sum = 0;
    for (std::size_t c = 0; c < channels; ++c) {
      const Image<double>& channel = light[first + c];
      sum = std::accumulate(channel.begin(), channel.end(), sum);
    }

    const double mean = sum / static_cast<double>(channels * light[first].pixel_count());
    const double gain = std::pow(wanted / std::max(mean, darkest), share);
    for (std::size_t c = 0; c < channels; ++c) {
      for (double& intensity : light[first + c]) intensity *= gain;
    }
  }
}

/// Adds the noise of the sensor.
void add_noise(std::vector<Image<double>>& frames, int n, const Photometry& photometry) {
  const Physics& physics = photometry.physics;
  const double level = physics.full_well > 0 ? 255 / physics.full_well : 0;  // of an electron
  const double constant = photometry.noise_variance + std::pow(level * physics.read_noise, 2);
  const bool differing = physics.dark_spread > 0 || physics.sensitivity_spread > 0;
  if (constant == 0 && level == 0 && physics.row_noise == 0 && !differing) return;

  const Size size = frames.front().size();
  for_each_row(size.height, [&](int row) {
    const auto first = static_cast<std::uint64_t>(row) * static_cast<std::uint64_t>(size.width);

    // The row's own offset in each frame.
    std::vector<double> of_row(frames.size(), 0);
    for (std::size_t i = 0; i < frames.size() && physics.row_noise != 0; ++i) {
      const std::uint64_t number = static_cast<std::uint64_t>(n) + i + of_rows;
      of_row[i] = physics.row_noise * gaussian(photometry.seed, number, first);
    }

    // The pixel's own sensitivity and offset, equal in all frames.
    for (int column = 0; column < size.width; ++column) {
      const std::uint64_t pixel = first + static_cast<std::uint64_t>(column);
      double sensitivity = 1, offset = 0;
      if (differing) {
        sensitivity += physics.sensitivity_spread * gaussian(0, of_sensitivities, pixel);
        offset = physics.dark_spread * gaussian(0, of_offsets, pixel);
      }

      // Shot noise grows with the light.
      for (std::size_t i = 0; i < frames.size(); ++i) {
        const std::uint64_t number = static_cast<std::uint64_t>(n) + i;
        double& intensity = frames[i](column, row);
        intensity = intensity * sensitivity + offset;

        const double shot = level * std::max(intensity, 0.0);
        intensity += of_row[i] + std::sqrt(constant + shot) *
                                     gaussian(photometry.seed, number, pixel);  // (3.10)
      }
    }
  });
}

void apply_tone_curve(Image<double>& picture, const Response& tone) {
  for (double& level : picture) level = 255 * light_at(tone, level / 255);
}

/// Adds a share of the difference to a blurred copy, which overshoots at edges.
void sharpen(Image<double>& picture, double share) {
  constexpr double deviation = 1;  // pixels
  for (double& level : picture) level = std::clamp(level, 0.0, 255.0);

  const Image<double> soft = blurred_picture(picture, Image<double>(picture.size(), deviation));
  std::ranges::transform(picture, soft, picture.begin(), [share](double level, double smooth) {
    return level + share * (level - smooth);
  });
}

template <class Pixel>
std::vector<Image<Pixel>> quantised(const std::vector<Image<double>>& exposures, int bits) {
  const double full_scale = (1 << bits) - 1;
  std::vector<Image<Pixel>> frames;

  for (const Image<double>& exposure : exposures) {
    Image<Pixel>& frame = frames.emplace_back(exposure.size());
    std::ranges::transform(exposure, frame.begin(), [&](double intensity) {
      return static_cast<Pixel>(std::lround(std::clamp(intensity / 255, 0.0, 1.0) * full_scale));
    });
  }

  return frames;
}

/// Compresses each picture and reads it back, the channels of a colour picture together.
void compress(std::vector<Image<std::uint8_t>>& frames, std::size_t channels, int quality) {
  const int samples = static_cast<int>(channels);
  const auto [width, height] = frames.front().size();
  const std::size_t pixels = frames.front().pixel_count();
  Image<std::uint8_t> picture({samples * width, height});

  for (std::size_t first = 0; first < frames.size(); first += channels) {
    for (std::size_t i = 0; i < channels * pixels; ++i) {
      picture.begin()[i] = frames[first + i % channels].begin()[i / channels];
    }

    recompress_jpeg(picture, samples, quality);

    for (std::size_t i = 0; i < channels * pixels; ++i) {
      frames[first + i % channels].begin()[i / channels] = picture.begin()[i];
    }
  }
}

}  // namespace

FrameSet camera_pictures(std::vector<Image<double>> light, int n, const Photometry& photometry,
                         std::size_t channels) {
  const Physics& physics = photometry.physics;

  // 1. The sensor.
  if (physics.auto_exposure != 0) expose_automatically(light, channels, physics.auto_exposure);
  add_noise(light, n, photometry);

  // 2. The camera's processing.
  for (Image<double>& picture : light) {
    if (!is_linear(physics.tone)) apply_tone_curve(picture, physics.tone);
    if (physics.sharpening != 0) sharpen(picture, physics.sharpening);
  }

  // 3. Its output.
  if (!photometry.bits) return FrameSet(std::move(light));
  if (*photometry.bits != 8) {
    return {quantised<std::uint16_t>(light, *photometry.bits), *photometry.bits};
  }

  std::vector<Image<std::uint8_t>> frames = quantised<std::uint8_t>(light, 8);
  if (physics.jpeg_quality > 0) compress(frames, channels, physics.jpeg_quality);
  return FrameSet(std::move(frames));
}

}  // namespace slipstream
