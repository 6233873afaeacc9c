#include "slipstream/simulate/sensor.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "slipstream/base/parallel_rows.h"
#include "slipstream/simulate/counted_random.h"

namespace slipstream {
namespace {

// What is random lies beyond the numbers of frames where it does not change from frame to frame.
constexpr std::uint64_t of_offsets = 0xfffff0, of_sensitivities = 0xfffff1, of_rows = 0x800000;

template <class Pixel>
std::vector<Image<Pixel>> quantised(const std::vector<Image<double>>& exposures, int bits) {
  const double full_scale = (1 << bits) - 1;
  std::vector<Image<Pixel>> frames;
  for (const Image<double>& exposure : exposures) {
    Image<Pixel>& frame = frames.emplace_back(exposure.size());
    std::transform(exposure.begin(), exposure.end(), frame.begin(), [&](double intensity) {
      return static_cast<Pixel>(std::lround(std::clamp(intensity / 255, 0.0, 1.0) * full_scale));
    });
  }
  return frames;
}

}  // namespace

void add_noise(Image<double>& frame, int n, const Photometry& photometry) {
  const Physics& physics = photometry.physics;
  const auto number = static_cast<std::uint64_t>(n);
  const double level = physics.full_well > 0 ? 255 / physics.full_well : 0;  // of an electron
  const double constant = photometry.noise_variance + std::pow(level * physics.read_noise, 2);
  const bool differing = physics.dark_spread > 0 || physics.sensitivity_spread > 0;
  if (constant == 0 && level == 0 && physics.row_noise == 0 && !differing) return;
  for_each_row(frame.height(), [&](int row) {
    const auto first = static_cast<std::uint64_t>(row) * static_cast<std::uint64_t>(frame.width());
    const double of_row =
        physics.row_noise == 0
            ? 0
            : physics.row_noise * gaussian(photometry.seed, number + of_rows, first);
    for (int column = 0; column < frame.width(); ++column) {
      const std::uint64_t pixel = first + static_cast<std::uint64_t>(column);
      double& intensity = frame(column, row);
      if (differing) {
        intensity *= 1 + physics.sensitivity_spread * gaussian(0, of_sensitivities, pixel);
        intensity += physics.dark_spread * gaussian(0, of_offsets, pixel);
      }
      const double shot = level * std::max(intensity, 0.0);
      intensity +=
          of_row + std::sqrt(constant + shot) * gaussian(photometry.seed, number, pixel);  // (3.10)
    }
  });
}

FrameSet digitised(std::vector<Image<double>> exposures, std::optional<int> bits) {
  if (!bits) return FrameSet(std::move(exposures));
  if (*bits == 8) return FrameSet(quantised<std::uint8_t>(exposures, 8));
  return {quantised<std::uint16_t>(exposures, *bits), *bits};
}

}  // namespace slipstream
