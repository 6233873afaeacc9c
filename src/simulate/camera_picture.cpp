#include "simulate/camera_picture.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

#include "base/parallel_rows.h"
#include "io/plain_pictures.h"
#include "simulate/frame_rows.h"
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

  const auto [width, height] = frames.front().size();
  for_each_row(height, [&, columns = std::size_t(width)](int row) {
    const std::uint64_t first = static_cast<std::uint64_t>(row) * columns;

    // The pixels' own sensitivities and offsets, equal in all frames.
    std::vector<double> sensitivity(columns, 1), offset(columns, 0), gaussians(columns);
    if (differing) {
      set_gaussians(0, of_sensitivities, first, sensitivity);
      for (double& factor : sensitivity) factor = 1 + physics.sensitivity_spread * factor;
      set_gaussians(0, of_offsets, first, offset);
      for (double& level_of_pixel : offset) level_of_pixel *= physics.dark_spread;
    }

    // In each frame, an offset of the row, and shot noise that grows with the light.
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const std::uint64_t number = static_cast<std::uint64_t>(n) + i;
      const double of_row = physics.row_noise * gaussian(photometry.seed, number + of_rows, first);
      set_gaussians(photometry.seed, number, first, gaussians);
      add_row_noise({sensitivity, offset, gaussians, constant, level, of_row},
                    {frames[i].row(row), columns});
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
      return static_cast<Pixel>(std::clamp(intensity / 255, 0.0, 1.0) * full_scale + 0.5);
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
