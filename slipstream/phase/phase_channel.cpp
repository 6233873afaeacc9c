#include "slipstream/phase/phase_channel.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>

#include "slipstream/image/parallel_rows.h"

namespace slipstream {

using std::numbers::pi;

std::vector<double> channel_cosines(int steps, int channel) {
  std::vector<double> weights;
  for (int n = 0; n < steps; ++n) {
    weights.push_back(2.0 / steps * std::cos(2 * pi * channel * n / steps));
  }
  return weights;
}

std::vector<double> channel_sines(int steps, int channel) {
  std::vector<double> weights;
  for (int n = 0; n < steps; ++n) {
    weights.push_back(2.0 / steps * std::sin(2 * pi * channel * n / steps));
  }
  return weights;
}

std::vector<double> mean_weights(int steps) {
  return std::vector<double>(static_cast<std::size_t>(steps), 1.0 / steps);
}

std::vector<double> half_phase_weights() {
  return {0.25, -0.25, 0.25, -0.25};
}

Image<double> weighted_sum(const FrameSet& frames, int first, std::span<const double> weights) {
  Image<double> sums(frames.size());
  frames.visit(first, static_cast<int>(weights.size()), [&](const auto& views) {
    for_each_row(frames.size().height, [&](int row) {
      for (int column = 0; column < frames.size().width; ++column) {
        double& sum = sums(column, row);
        for (std::size_t n = 0; n < weights.size(); ++n) {
          sum += weights[n] * static_cast<double>(views[n](column, row));
        }
      }
    });
  });
  return sums;
}

Image<double> channel_modulation(const FrameSet& frames, int steps, int channel) {
  Image<double> C = weighted_sum(frames, 0, channel_cosines(steps, channel));
  const Image<double> S = weighted_sum(frames, 0, channel_sines(steps, channel));
  std::transform(C.begin(), C.end(), S.begin(), C.begin(),
                 [](double c, double s) { return std::hypot(c, s); });
  return C;
}

}  // namespace slipstream
