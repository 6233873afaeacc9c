// Scan after scan through one engine: tables are built once, and from the second scan on nothing is
// allocated. The frames stand in memory of the caller's, as a camera's driver would fill it.
#include <cstdint>
#include <cstdio>
#include <vector>

#include "slipstream/codes/registry.h"
#include "slipstream/reconstruct/engine.h"
#include "slipstream/simulate/named_scenes.h"

using namespace slipstream;

int main() {
  const Scanner scanner = example_scanner({640, 480});
  const Sequence sequence{.strategy = make_strategy("pmp", {{"steps", 3}})};
  Engine engine(scanner, sequence);

  // Three frames of 640x480 in rows of 704 bytes, one behind another.
  constexpr Size size{640, 480};
  constexpr std::ptrdiff_t stride = 704;
  std::vector<std::uint8_t> buffer(3 * 480 * stride);
  Frames<std::uint8_t> views;
  for (int n = 0; n < 3; ++n) views.emplace_back(buffer.data() + n * 480 * stride, size, stride);
  const FrameViews frames(views);

  // Three steps of a coordinate that rises from left to right, as a flat thing would show them.
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
