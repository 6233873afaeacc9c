#include "check/wrapped_levels.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "slipstream/check.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"
#include "tests/check/mistakes.h"

namespace slipstream::wrapped_levels_test {

TEST(WrappedLevels, OfBrightenedFramesAreNamed) {
  VirtualWorld world{.scanner = example_scanner({320, 240})};
  world.scene = scene_named("statue", world.scanner);
  world.photometry = {.ambient = 3, .noise_variance = 1.5};

  for (const Strategy& strategy :
       {make_strategy("dual-frequency", {{"steps", 4}}), make_strategy("pmp", {{"steps", 4}})}) {
    const VirtualScan taken =
        take_scan(world.scanner, world.scene, pattern_set(strategy, Axis::x), world.photometry);
    Scan scan{.frames = taken.frames,
              .sequence = {strategy, Axis::x, {}, world.scanner.projector.size},
              .scanner = as_calibrated(world)};
    pixels(all_frames(scan.frames.count()),
           [](double level, int, int) { return std::fmod(std::round(2 * level), 256); })(scan);

    const ScanFindings found = check_scan(scan);
    ASSERT_FALSE(found.findings.empty()) << label_of(strategy);
    const Finding wrapped = gravest_first(found.findings).front();
    EXPECT_EQ(wrapped.kind, FindingKind::clipped) << text_of(wrapped);
    EXPECT_EQ(wrapped.severity, Severity::wrong) << text_of(wrapped);
  }
}

}  // namespace slipstream::wrapped_levels_test
