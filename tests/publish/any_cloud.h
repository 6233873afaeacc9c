#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <random>
#include <vector>

#include "slipstream/live_pipeline.h"
#include "slipstream/scanner.h"

namespace slipstream {

inline const Size size{61, 43};

inline Lens camera() {
  Lens lens{.size = size};
  lens.intrinsic << 80, 0, 30, 0, 82, 20, 0, 0, 1;
  lens.distortion = make_distortion(std::vector<double>{-0.1, 0.05, 0.001, -0.002, 0.01});
  return lens;
}

/// Ray of each pixel, row by row. Computed once: it is slow under sanitizers.
inline const std::vector<Eigen::Vector3d>& pixel_rays() {
  static const std::vector<Eigen::Vector3d> all = [] {
    const Lens lens = camera();
    std::vector<Eigen::Vector3d> made;
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        made.push_back(ray_through(lens, {column, row}));
      }
    }
    return made;
  }();
  return all;
}

/// Random points, one in eight missing, from four frames captured now.
inline Pooled<LiveCloud> any_cloud(std::uint64_t sequence) {
  std::mt19937 random(static_cast<unsigned>(sequence));
  Pool<LiveCloud> pool(1, [] { return LiveCloud{.cloud = Cloud(size)}; });
  Pooled<LiveCloud> pooled = pool.take();
  LiveCloud& live = pooled.fill();
  Pool<Frame> frames(1, [] { return Frame(FrameFormat{size}); });
  Pooled<Frame> frame = frames.take();
  live.newest = {.sequence = sequence, .host_time = std::chrono::steady_clock::now()};
  frame.fill().stamp = live.newest;
  live.frames.assign(4, frame);
  std::uniform_real_distribution<float> any(0, 1);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      live.cloud.intensity(column, row) = 300 * any(random) - 20;
      if (any(random) < 0.125F) continue;
      const Eigen::Vector3d& ray =
          pixel_rays()[static_cast<std::size_t>(row * size.width + column)];
      const float z = 500 + 300 * any(random);
      live.cloud.x(column, row) = static_cast<float>(ray.x()) * z;
      live.cloud.y(column, row) = static_cast<float>(ray.y()) * z;
      live.cloud.z(column, row) = z;
      live.cloud.validity(column, row) = Validity::valid;
    }
  }
  return pooled;
}

/// The cloud with another colour at each pixel.
inline Pooled<LiveCloud> coloured_cloud() {
  Pooled<LiveCloud> live = any_cloud(3);
  Image<Colour>& colours = live.fill().cloud.colour;
  colours = Image<Colour>(size);
  for_each_pixel_in_order(size, [&](int column, int row) {
    colours(column, row) = {static_cast<std::uint8_t>(4 * column),
                            static_cast<std::uint8_t>(5 * row),
                            static_cast<std::uint8_t>(255 - 4 * column)};
  });
  return live;
}

}  // namespace slipstream
