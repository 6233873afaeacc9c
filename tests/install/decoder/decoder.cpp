// A program outside the project that has the packages of the decoder alone: a wall in front of
// camera and projector, to a cloud.
#include <cmath>
#include <cstdint>
#include <utility>

#include <slipstream/engine.h>
#include <slipstream/phase_shifting.h>

int main() {
  using namespace slipstream;
  Lens lens{.size = {64, 48}};
  lens.intrinsic << 64, 0, 32, 0, 64, 24, 0, 0, 1;
  // At 1000 mm the camera's column x sees the projector's x + 6.4.
  const Scanner scanner{.camera = lens, .projector = lens, .translation = {100, 0, 0}};
  const Sequence sequence{.strategy = PhaseMeasuring{.steps = 4, .frequency = 1}};
  const PatternSet patterns = pattern_set(sequence);
  FrameSet::Images8 pictures;
  for (int n = 0; n < patterns.count; ++n) {
    Image<std::uint8_t> picture(lens.size);
    for (int y = 0; y < lens.size.height; ++y) {
      for (int x = 0; x < lens.size.width; ++x) {
        const double seen = patterns.intensity(n, std::fmod((x + 6.4) / lens.size.width, 1));
        picture(x, y) = static_cast<std::uint8_t>(20 + 0.8 * seen);
      }
    }
    pictures.push_back(std::move(picture));
  }
  const FrameSet frames(std::move(pictures));
  Cloud cloud;
  Engine(scanner, sequence).cloud(frames, cloud);
  return point_count(cloud) > 1000 ? 0 : 1;
}
