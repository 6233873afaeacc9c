// A virtual scan and its expected result, for tests of extensions.
#pragma once

#include <cmath>
#include <cstddef>

#include <gtest/gtest.h>

#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream {

struct Seen {
  EngineSetup setup;
  VirtualScan scan;
};

inline Seen seen_under(const Strategy& strategy, const ReconstructSettings& settings = {}) {
  const Scanner scanner = example_scanner({160, 120});
  return {
      .setup = {scanner, {.strategy = strategy, .projector = scanner.projector.size}, settings},
      .scan = take_scan(scanner, scene_named("boxes", scanner), pattern_set(strategy, Axis::x))};
}

/// More than 80 % of lit pixels are within 1 mm of the true depth.
inline void expect_true_depths(const Seen& seen, Engine& engine) {
  Cloud cloud;
  engine.cloud(seen.scan.frames, cloud);
  std::size_t lit = 0, near = 0;
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    lit += std::isnan(seen.scan.coordinate.begin()[i]) ? 0 : 1;
    near += std::abs(cloud.z.begin()[i] - seen.scan.depth.begin()[i]) < 1 ? 1 : 0;
  }
  EXPECT_GT(static_cast<double>(near), 0.8 * static_cast<double>(lit));
}

}  // namespace slipstream
