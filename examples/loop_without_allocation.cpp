// Reconstructs many scans with one engine: tables are built once, and only the first scan allocates
// memory. The caller owns the frame buffers, as with a camera driver.
#include <cstdint>
#include <cstdio>
#include <vector>

#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"

using namespace slipstream;

int main() {
  const Scanner scanner = example_scanner({640, 480});
  const Sequence sequence{.strategy = make_strategy("pmp", {{"steps", 3}})};
  Engine engine(scanner, sequence);

  // Three frames of 640x480 in one buffer, each row padded to 704 bytes.
  constexpr Size size{640, 480};
  constexpr std::ptrdiff_t stride = 704;
  std::vector<std::uint8_t> buffer(3 * 480 * stride);
  Frames<std::uint8_t> views;
  for (int n = 0; n < 3; ++n) views.emplace_back(buffer.data() + n * 480 * stride, size, stride);
  const FrameViews frames(views);

  // Simulates a flat object: the projector coordinate rises from left to right.
  const PatternSet patterns = pattern_set(sequence);
  for (int n = 0; n < 3; ++n) {
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        const double light = patterns.intensity(n, column / 640.0);
        buffer[static_cast<std::size_t>((n * 480 + row) * stride + column)] =
            static_cast<std::uint8_t>(20 + 0.8 * light);
      }
    }
  }

  Cloud cloud;
  for (int scan = 0; scan < 100; ++scan) engine.cloud(frames, cloud);
  std::printf("%zu points by the %s engine\n", point_count(cloud),
              engine.backend_for(frames).c_str());
}
