#include "slipstream/simulate/moved_board.h"

#include <variant>

#include <gtest/gtest.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/registry.h"
#include "slipstream/codes/sequence.h"
#include "slipstream/simulate/board_poses.h"
#include "slipstream/simulate/named_scenes.h"

namespace slipstream::moved_board_test {

VirtualWorld small_world() {
  return {.scanner = example_scanner({32, 24}), .photometry = {.bits = 8}};
}

Body sheet() {
  return {.shape = Board{80, 60}};
}

std::vector<PatternSet> sets_of() {
  return along_both_axes(
      {.strategy = default_strategy(), .projector = {1280, 800}, .marker = true});
}

TEST(MovedBoard, StaysForItsCyclesAndMovesWithinOne) {
  const VirtualWorld world = small_world();
  const auto poses = board_poses(world.scanner, 3, 80, 60);
  int rendered = 0;
  const Reel reel = moved_board(world, sheet(), poses, sets_of(), 2, [&] { ++rendered; });
  std::size_t cycle = 0;
  for (const PatternSet& set : sets_of()) cycle += static_cast<std::size_t>(set.count);
  EXPECT_EQ(cycle, 2U * static_cast<std::size_t>(frame_count(default_strategy())) + 1);
  EXPECT_EQ(rendered, 3);
  EXPECT_EQ(reel.order.size(), 3 * 3 * cycle);
  EXPECT_EQ(reel.frames.size(), 3 * 2 * cycle);
  EXPECT_EQ(reel.enough, (2 * 3 + 1) * cycle);
  for (std::size_t k = 0; k < cycle; ++k) {
    EXPECT_EQ(reel.order[k], reel.order[k + cycle]) << "still";
    EXPECT_NE(reel.order[k], reel.order[k + 2 * cycle]) << "moving";
  }
}

TEST(MovedBoard, NeedsPosesAndCycles) {
  const auto ignore = [] {};
  const auto poses = board_poses(small_world().scanner, 1, 80, 60);
  EXPECT_THROW(moved_board(small_world(), sheet(), {}, sets_of(), 2, ignore), Error);
  EXPECT_THROW(moved_board(small_world(), sheet(), poses, {}, 2, ignore), Error);
  EXPECT_THROW(moved_board(small_world(), sheet(), poses, sets_of(), 0, ignore), Error);
}

}  // namespace slipstream::moved_board_test
