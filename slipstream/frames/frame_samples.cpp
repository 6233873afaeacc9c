#include "slipstream/frames/frame_samples.h"

#include <algorithm>

#include "slipstream/base/spread_place.h"

namespace slipstream {

SampleGrid::SampleGrid(Size size) {
  const int beside = std::max(1, size.width / 64);
  const auto place = [](double part, int length) {
    return std::min(static_cast<int>(part * length), length - 1);
  };
  for (int i = 0; i < std::min(pairs, size.width * size.height / 2); ++i) {
    const auto [x, y] = spread_place(i);
    const int column = place(x, size.width), row = place(y, size.height);
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
