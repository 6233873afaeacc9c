#include "codes/guard_sequence.h"

#include <gtest/gtest.h>

#include "slipstream/strategy.h"

namespace slipstream::guard_sequence_test {

TEST(GuardSequence, HasSixFramesAcrossTheScan) {
  Sequence scan{.strategy = make_strategy("pmp", {{"steps", 4}}),
                .light = {.alpha_p = 200, .beta_p = 30},
                .projector = {1280, 800},
                .marker = true,
                .motion = 2};
  for (const Axis axis : {Axis::x, Axis::y}) {
    scan.axis = axis;
    const Sequence guard = guard_sequence(scan);
    EXPECT_EQ(guard.axis, across(axis));
    EXPECT_EQ(frame_count(guard), 6);
    EXPECT_EQ(cycle_length(guard), 6);
    EXPECT_TRUE(has_coordinate(guard.strategy));
    EXPECT_EQ(guard.light, scan.light);
    EXPECT_NO_THROW(require_shown(guard));
  }
}

TEST(GuardSequence, KeepsTheExposures) {
  const Sequence scan{.projector = {1280, 800}, .exposures = {1, 4}};
  EXPECT_EQ(frame_count(guard_sequence(scan)), 12);
}

TEST(GuardSequence, NeedsOneAxisAndAProjectorThatShowsIt) {
  EXPECT_TRUE(can_be_guarded({.projector = {1280, 800}}));
  EXPECT_FALSE(can_be_guarded({.projector = {1280, 800}, .both_axes = true}));
  EXPECT_FALSE(can_be_guarded({}));
  EXPECT_FALSE(can_be_guarded({.projector = {1280, 32}}));
}

}  // namespace slipstream::guard_sequence_test
