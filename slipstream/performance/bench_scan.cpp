#include "slipstream/performance/bench_scan.h"

#include <cstddef>
#include <utility>

#include "slipstream/simulate/named_scenes.h"
#include "slipstream/simulate/virtual_scanner.h"

namespace slipstream {
namespace {

Image<std::uint8_t> enlarged(const ImageView<const std::uint8_t>& image, int k) {
  Image<std::uint8_t> large({image.width() * k, image.height() * k});
  for (int row = 0; row < large.height(); ++row) {
    for (int column = 0; column < large.width(); ++column) {
      large(column, row) = image(column / k, row / k);
    }
  }
  return large;
}

}  // namespace

BenchScan bench_scan(const Strategy& strategy) {
  const Scanner scanner = example_scanner({640, 480});
  return {scanner,
          take_scan(scanner, scene_named("statue", scanner), pattern_set(strategy, Axis::x),
                    {.ambient = bench_ambient, .noise_variance = 1.55, .bits = 8})
              .frames};
}

BenchScan enlarged(const BenchScan& scan, int k) {
  FrameSet::Images8 large;
  scan.frames.visit([&]<class Pixel>(const Frames<Pixel>& views) {
    if constexpr (sizeof(Pixel) == 1) {
      for (const auto& view : views) large.push_back(enlarged(view, k));
    }
  });
  const Size size = scan.scanner.camera.size;
  return {example_scanner({size.width * k, size.height * k}), FrameSet(std::move(large))};
}

}  // namespace slipstream
