#include "check/wrapped_levels.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "slipstream/check.h"
#include "slipstream/strategy.h"
#include "tests/check/mistakes.h"
#include "tests/check/scene_scan.h"

namespace slipstream::wrapped_levels_test {

TEST(WrappedLevels, OfBrightenedFramesAreNamed) {
  for (const Strategy& strategy :
       {make_strategy("dual-frequency", {{"steps", 4}}), make_strategy("pmp", {{"steps", 4}})}) {
    Scan scan = scene_scan("statue", strategy);
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
