#include "slipstream/publish/web_cloud.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <variant>

#include "slipstream/geometry/scanner.h"
#include "slipstream/publish/little_endian.h"

namespace slipstream {
namespace {

constexpr int most_steps = 65534;

int thinned(int pixels, int step) {
  return (pixels + step - 1) / step;
}

/// Calls `visit` for each pixel that is sent.
template <class Visit>
void each_sent(Size size, Visit visit) {
  const int step = web_step(size);
  for (int row = 0; row < size.height; row += step) {
    for (int column = 0; column < size.width; column += step) visit(column, row);
  }
}

DepthRange range_of(const Image<float>& depth) {
  DepthRange range{std::numeric_limits<double>::max(), std::numeric_limits<double>::lowest()};
  for (const float z : depth) {
    if (std::isnan(z)) continue;
    range.nearest = std::min<double>(range.nearest, z);
    range.farthest = std::max<double>(range.farthest, z);
  }
  return range.nearest <= range.farthest ? range : DepthRange{};
}

void append_grey(std::string& bytes, const Frame& frame) {
  std::visit(
      [&](const auto& pixels) {
        each_sent(pixels.size(), [&](int column, int row) {
          append(bytes, static_cast<std::uint8_t>(pixels(column, row) >> (frame.bits - 8)));
        });
      },
      frame.pixels);
}

}  // namespace

int web_step(Size camera) {
  int step = 1;
  const auto sent = [&] {
    return std::int64_t{thinned(camera.width, step)} * thinned(camera.height, step);
  };
  while (sent() > most_web_pixels) ++step;
  return step;
}

std::string web_rays(const Lens& camera) {
  std::string bytes;
  each_sent(camera.size, [&](int column, int row) {
    const Eigen::Vector3d ray = ray_through(camera, {column, row});
    append(bytes, static_cast<float>(ray.x()));
    append(bytes, static_cast<float>(ray.y()));
  });
  return bytes;
}

std::string web_cloud(const LiveCloud& live) {
  const Cloud& cloud = live.cloud;
  const Frame& frame = *live.frames.front();
  const bool has_depth = !cloud.z.empty();
  const Size size = frame.format().size;
  const int step = web_step(size);
  const DepthRange range = has_depth ? range_of(cloud.z) : DepthRange{};
  const auto depth_step =
      std::max(static_cast<float>((range.farthest - range.nearest) / most_steps),
               std::numeric_limits<float>::min());
  std::string bytes;
  bytes.reserve(24 + 3 * static_cast<std::size_t>(most_web_pixels));
  append(bytes, thinned(size.width, step));
  append(bytes, thinned(size.height, step));
  append(bytes, std::int32_t{has_depth});
  append(bytes, static_cast<std::int32_t>(has_depth ? point_count(cloud) : 0));
  append(bytes, static_cast<float>(range.nearest));
  append(bytes, depth_step);
  if (!has_depth) {
    bytes.append(2 * static_cast<std::size_t>(thinned(size.width, step)) *
                     static_cast<std::size_t>(thinned(size.height, step)),
                 '\0');
    append_grey(bytes, frame);
    return bytes;
  }
  const auto nearest = static_cast<float>(range.nearest);
  each_sent(size, [&](int column, int row) {
    const float z = cloud.z(column, row);
    const float steps = std::min(std::round((z - nearest) / depth_step), float{most_steps});
    append(bytes, static_cast<std::uint16_t>(std::isnan(z) ? 0 : static_cast<int>(steps) + 1));
  });
  each_sent(size,
            [&](int column, int row) { append(bytes, grey_level(cloud.intensity(column, row))); });
  return bytes;
}

}  // namespace slipstream
