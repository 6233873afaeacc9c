// A program outside the project: a scan by the virtual scanner to a cloud.
#include <slipstream/reconstruct/reconstructor.h>
#include <slipstream/simulate/named_scenes.h>
#include <slipstream/simulate/virtual_scanner.h>

int main() {
  using namespace slipstream;
  const Scanner scanner = example_scanner({64, 48});
  const Strategy strategy = PhaseMeasuring{.steps = 4, .frequency = 1};
  const VirtualScan scan =
      take_scan(scanner, scene_named("sphere", scanner), pattern_set(strategy, Axis::x));
  const Reconstruction result = Reconstructor(scanner, strategy, Axis::x)(scan.frames);
  return point_count(result.cloud) > 100 ? 0 : 1;
}
