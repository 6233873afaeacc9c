// Simulates a scan, without hardware, and compares the cloud with the true depth.
#include "slipstream/virtual_scanner.h"

#include <cmath>
#include <cstdio>

#include "slipstream/named_scenes.h"
#include "slipstream/scan_job.h"
#include "slipstream/strategy.h"

using namespace slipstream;

int main() {
  const Scanner scanner = example_scanner({640, 480});
  const Sequence sequence{
      .strategy = make_strategy("dual-frequency", {{"steps", 4}, {"high", 32}, {"low", 1}})};
  const VirtualScan scan = take_scan(scanner, scene_named("statue", scanner), pattern_set(sequence),
                                     {.ambient = 5, .noise_variance = 1.55, .bits = 8});
  const Cloud cloud =
      reconstruct({.frames = scan.frames, .sequence = sequence, .scanner = scanner}).cloud;

  double squares = 0;
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    const double error = cloud.z.begin()[i] - scan.depth.begin()[i];
    if (std::isfinite(error)) squares += error * error;
  }
  const auto points = static_cast<double>(point_count(cloud));
  std::printf("%.0f points, RMS error %.3f mm\n", points, std::sqrt(squares / points));
}
