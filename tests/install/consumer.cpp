// A program outside the project: a scan by the virtual scanner to a cloud.
#include <slipstream/engine.h>
#include <slipstream/named_scenes.h>
#include <slipstream/phase_shifting.h>
#include <slipstream/virtual_scanner.h>

int main() {
  using namespace slipstream;
  const Scanner scanner = example_scanner({64, 48});
  const Sequence sequence{.strategy = PhaseMeasuring{.steps = 4, .frequency = 1}};
  const VirtualScan scan =
      take_scan(scanner, scene_named("sphere", scanner), pattern_set(sequence));
  Cloud cloud;
  Engine(scanner, sequence).cloud(scan.frames, cloud);
  return point_count(cloud) > 100 ? 0 : 1;
}
