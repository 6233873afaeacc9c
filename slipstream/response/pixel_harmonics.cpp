#include "slipstream/response/pixel_harmonics.h"

#include <cstddef>
#include <numbers>
#include <vector>

#include "slipstream/base/parallel_rows.h"

namespace slipstream {

using std::numbers::pi;

Image<MeasuredHarmonics> pixel_harmonics(const FrameViews& frames, int first, int steps) {
  std::vector<std::complex<double>> turns(static_cast<std::size_t>(steps));
  for (std::size_t n = 0; n < turns.size(); ++n) {
    turns[n] = std::polar(1.0, 2 * pi * static_cast<double>(n) / steps);
  }
  Image<MeasuredHarmonics> pixels(frames.size());
  frames.part(first, steps).visit([&](const auto& views) {
    const auto N = views.size();
    for_each_row(frames.size().height, [&](int row) {
      for (int column = 0; column < frames.size().width; ++column) {
        MeasuredHarmonics& pixel = pixels(column, row);
        for (std::size_t n = 0; n < N; ++n) {
          const auto I_n = static_cast<double>(views[n](column, row));
          pixel.mean += I_n;
          pixel.fundamental += I_n * turns[n];
          pixel.second += I_n * turns[2 * n % N];
          pixel.third += I_n * turns[3 * n % N];
        }
        const auto count = static_cast<double>(N);
        pixel.mean /= count;
        pixel.fundamental *= 2 / count;
        pixel.second *= 2 / count;
        pixel.third *= 2 / count;
      }
    });
  });
  return pixels;
}

Image<std::uint8_t> well_lit(const Image<MeasuredHarmonics>& pixels, const FrameViews& frames,
                             double minimum) {
  const double least = minimum > 0 ? minimum : frames.full_scale() / 16;
  const Image<std::uint8_t> saturated = saturation_mask(frames);
  Image<std::uint8_t> lit(pixels.size());
  for (std::size_t i = 0; i < pixels.pixel_count(); ++i) {
    lit.begin()[i] = pixels.begin()[i].B_1() >= least && saturated.begin()[i] == 0 ? 1 : 0;
  }
  return lit;
}

}  // namespace slipstream
