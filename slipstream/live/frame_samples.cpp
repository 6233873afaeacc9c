#include "slipstream/live/frame_samples.h"

#include <algorithm>
#include <cmath>

namespace slipstream {

SampleGrid::SampleGrid(Size size) {
  // Steps of the inverses of 1.3247..., the root of x^3 = x + 1, and of its square spread points
  // over a square evenly and without a grid that stripes could fall in step with.
  constexpr double step_x = 0.7548776662466927, step_y = 0.5698402909980532;
  const int beside = std::max(1, size.width / 64);
  const auto place = [](double part, int length) {
    return std::min(static_cast<int>(part * length), length - 1);
  };
  for (int i = 0; i < pairs; ++i) {
    const int column = place(std::fmod(0.5 + i * step_x, 1.0), size.width);
    const int row = place(std::fmod(0.5 + i * step_y, 1.0), size.height);
    for (const int away : {0, beside}) {
      pixels_.push_back(static_cast<std::size_t>(std::min(row + away, size.height - 1)) *
                            static_cast<std::size_t>(size.width) +
                        static_cast<std::size_t>(std::min(column + away, size.width - 1)));
    }
  }
}

void SampleGrid::sample(const Frame& frame, std::vector<float>& samples) const {
  samples.resize(pixels_.size());
  const float scale = 255.0F / static_cast<float>((1 << frame.bits) - 1);
  std::visit(
      [&](const auto& image) {
        const auto* const pixels = image.begin();
        std::transform(pixels_.begin(), pixels_.end(), samples.begin(),
                       [&](std::size_t i) { return scale * static_cast<float>(pixels[i]); });
      },
      frame.pixels);
}

}  // namespace slipstream
