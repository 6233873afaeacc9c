// Your own strategy, declared as a layout and run by the fused engine: two frames shifted by a
// quarter of a period, and a flat one (2+1 phase shifting).
#include <cmath>
#include <cstdio>
#include <numbers>
#include <string_view>

#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/virtual_scanner.h"

using namespace slipstream;

struct QuarterPhase {
  static constexpr std::string_view name = "quarter-phase";
  double frequency = 1;

  template <class Self, class Visit>
  static void for_each_setting(Self& self, const Visit& visit) {
    visit("frequency", "periods across the projector field", self.frequency);
  }
  void require_valid() const {
    if (!(frequency > 0 && frequency <= 1)) throw Error("quarter-phase: at most one period");
  }
  [[nodiscard]] double shape(int n, double y) const {
    const double phase = 2 * std::numbers::pi * frequency * y;
    return n == 0 ? 0.5 + 0.5 * std::cos(phase) : n == 1 ? 0.5 + 0.5 * std::sin(phase) : 0.5;
  }
  [[nodiscard]] Layout layout() const {
    return {
        .frames = 3,
        .bands = {
            {.periods = frequency, .cosine = {1, 0, -1}, .sine = {0, 1, -1}, .mean = {0, 0, 1}}}};
  }
};

int main() {
  const Scanner scanner = example_scanner({640, 480});
  const Sequence sequence{.strategy = QuarterPhase{}};
  const VirtualScan scan = take_scan(scanner, scene_named("sphere", scanner), pattern_set(sequence),
                                     {.ambient = 5, .noise_variance = 1.55, .bits = 8});
  Engine engine(scanner, sequence);
  Cloud cloud;
  engine.cloud(scan.frames, cloud);
  std::printf("%zu points by the %s engine\n", point_count(cloud),
              engine.backend_for(scan.frames).c_str());
}
