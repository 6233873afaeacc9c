#include "slipstream/scan.h"

#include <cstdint>

#include <gtest/gtest.h>

#include "tests/io/expect_error.h"

namespace slipstream::scan_test {

/// Black frames of patterns along both axes, whose code has a bit less along y.
Scan scan_of(int frames) {
  const SequenceChanges patterns{.strategy = "gray-phase",
                                 .period_pixels = std::vector{18.0},
                                 .axes = "both",
                                 .projector = Size{1280, 800}};
  return {.frames = FrameSet(
              FrameSet::Images8(static_cast<std::size_t>(frames), Image<std::uint8_t>({8, 8}))),
          .sequence = changed(Sequence{}, patterns)};
}

TEST(Scan, MergedScanHasTheFramesAlongEachAxis) {
  const Scan scan = merged(scan_of(12 + 11));
  EXPECT_EQ(scan.frames.count(), 12);
  EXPECT_EQ(scan.sequence.axis, Axis::x);

  ASSERT_EQ(scan.other_axis.size(), 1U);
  EXPECT_EQ(scan.other_axis.front().frames.count(), 11);
  EXPECT_EQ(scan.other_axis.front().sequence.axis, Axis::y);
}

TEST(Scan, MergedScanRefusesTooFewFrames) {
  expect_error([] { (void)merged(scan_of(12 + 10)); }, {"22 frames", "are 23"});
  expect_error([] { (void)merged(scan_of(1)); }, {"1 frame", "are 23"});
}

}  // namespace slipstream::scan_test
