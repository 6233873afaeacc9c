// Reels rendered while they are shown. Tier: every change; seconds, as the pictures are small.
// virtual_scanner_test.cpp tests what frames show; here it is when they are there.
#include "simulate/rendered_reel.h"

#include <gtest/gtest.h>

#include "simulate/looped_scene.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/sequence.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "slipstream/virtual_world.h"

namespace slipstream {
namespace {

constexpr auto long_enough = std::chrono::seconds(60);
constexpr int cycles = 3;

VirtualWorld moving_world() {
  WorldSettings settings{.scene = "sphere"};
  settings.world = "ideal";
  settings.camera = {48, 36};
  settings.motion.step = {0.5, 0, 0};
  return virtual_world(settings);
}

PatternSet patterns_of(const VirtualWorld& world) {
  return pattern_set({.strategy = default_strategy(), .projector = world.scanner.projector.size});
}

ReelScript script_of(FirstRest rest) {
  const VirtualWorld world = moving_world();
  return looped_scene(world.scanner, world.scene, patterns_of(world), world.photometry, cycles,
                      rest);
}

/// Lets the rendering thread render one moment at a time.
class Gate {
 public:
  std::function<void(double)> pass() {
    return [this](double) {
      std::unique_lock lock(mutex_);
      changed_.wait(lock, [this] { return passes_ > 0; });
      --passes_;
    };
  }
  void open(int moments) {
    const std::lock_guard lock(mutex_);
    passes_ += moments;
    changed_.notify_all();
  }

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  int passes_ = 0;
};

const Image<std::uint8_t>& picture(const Frame& frame) {
  return std::get<Image<std::uint8_t>>(frame.pixels);
}

bool same(const Frame& one, const Frame& other) {
  return std::ranges::equal(picture(one), picture(other));
}

TEST(RenderedReel, HasTheFramesOfVirtualFrames) {
  const VirtualWorld world = moving_world();
  const std::vector<Frame> whole =
      virtual_frames(world.scanner, world.scene, patterns_of(world), world.photometry, cycles);
  const RenderedReel reel(script_of(FirstRest::none));

  ASSERT_EQ(reel.order().size(), whole.size());
  for (std::size_t k = 0; k < whole.size(); ++k) {
    ASSERT_TRUE(reel.wait_for(k, RenderedReel::Clock::now() + long_enough)) << k;
    EXPECT_TRUE(same(*reel.at(k), whole[k])) << k;
    EXPECT_EQ(reel.at(k)->stamp.pattern_index, whole[k].stamp.pattern_index) << k;
  }
}

TEST(RenderedReel, DeliversTheFirstCycleBeforeTheRest) {
  Gate gate;
  auto reel = std::make_shared<RenderedReel>(script_of(FirstRest::until_rendered), gate.pass());
  const auto cycle = static_cast<std::size_t>(frame_count(default_strategy()));
  const std::size_t rest_length = reel->hold_length();
  ASSERT_EQ(rest_length, 2 * cycle);
  VirtualCamera camera(reel);
  camera.start();

  // 1. The scene rests: two cycles, with noise of their own, again and again.
  Frame frame;
  std::vector<Frame> rest;
  for (std::size_t k = 0; k < 2 * rest_length; ++k) {
    ASSERT_EQ(camera.next(frame, long_enough), Arrival::frame) << k;
    EXPECT_EQ(frame.stamp.sequence, k);
    EXPECT_EQ(frame.stamp.pattern_index, static_cast<int>(k % cycle));
    if (k < rest_length) {
      rest.push_back(frame);
    } else {
      EXPECT_TRUE(same(frame, rest[k % rest_length])) << k;
    }
  }
  EXPECT_FALSE(same(rest[0], rest[cycle]));

  // 2. Once the loop is rendered, it moves, beginning with its first pattern.
  gate.open(1000);
  ASSERT_TRUE(reel->wait_for(reel->order().size() - 1, RenderedReel::Clock::now() + long_enough));
  while (!reel->has(0, reel->order().size())) std::this_thread::yield();
  const Reel whole = rendered(script_of(FirstRest::none));
  for (std::size_t k = 0; k < rest_length; ++k) {
    ASSERT_EQ(camera.next(frame, long_enough), Arrival::frame) << "the last rest, " << k;
  }
  for (std::size_t k = 0; k < 2 * whole.order.size(); ++k) {
    ASSERT_EQ(camera.next(frame, long_enough), Arrival::frame) << k;
    EXPECT_TRUE(same(frame, whole.frames[whole.order[k % whole.order.size()]])) << k;
  }
}

TEST(RenderedReel, WithoutAPaceGivesEachFrameOnceAndWaits) {
  Gate gate;
  VirtualCamera camera(std::make_shared<RenderedReel>(script_of(FirstRest::once), gate.pass()));
  camera.start();

  Frame frame;
  const auto cycle = static_cast<std::size_t>(frame_count(default_strategy()));
  for (std::size_t k = 0; k < cycle; ++k) {
    ASSERT_EQ(camera.next(frame, long_enough), Arrival::frame) << k;
  }
  EXPECT_NE(camera.next(frame, std::chrono::milliseconds(200)), Arrival::frame)
      << "only the cycle at rest is rendered";

  gate.open(1000);
  EXPECT_EQ(camera.next(frame, long_enough), Arrival::frame);
  EXPECT_EQ(frame.stamp.sequence, cycle);
  EXPECT_EQ(camera.counters().lost, 0U);
}

TEST(RenderedReel, AtAPaceLosesNothingWhileItRenders) {
  Gate gate;
  VirtualCamera camera(std::make_shared<RenderedReel>(script_of(FirstRest::none), gate.pass()),
                       1000.0);
  camera.start();

  Frame frame;
  while (camera.next(frame, std::chrono::milliseconds(200)) == Arrival::frame) {
  }
  const std::uint64_t before = camera.counters().delivered;
  std::this_thread::sleep_for(std::chrono::milliseconds(100));  // a hundred frames' time

  gate.open(1000);
  ASSERT_EQ(camera.next(frame, long_enough), Arrival::frame);
  EXPECT_EQ(frame.stamp.sequence, before);
  EXPECT_EQ(camera.counters().lost, 0U);
}

TEST(RenderedReel, ABoardRestsUntilItsNextPoseIsRendered) {
  const VirtualWorld world = moving_world();
  const Body sheet{.shape = Board{80, 60}};
  const ReelScript script =
      moved_board(world, sheet, board_poses(world.scanner, 2, 80, 60), {patterns_of(world)}, 2);
  Gate gate;
  ReelPlayer player(std::make_shared<RenderedReel>(script, gate.pass()));
  const std::size_t cycle = script.cycle.size();

  ASSERT_TRUE(player.wait_for_frame(RenderedReel::Clock::now() + long_enough));
  while (!player.reel().has(0, cycle)) std::this_thread::yield();
  player.advance(7 * cycle);
  EXPECT_EQ(player.frame()->stamp.sequence, 0U) << "the first pose";

  gate.open(1000);
  while (!player.reel().has(0, script.order.size())) std::this_thread::yield();
  player.advance(2 * cycle);
  EXPECT_EQ(player.frame()->stamp.sequence, 2 * cycle) << "the second pose";
}

TEST(RenderedReel, ManyStepsAtOnceLeadToTheSameFrame) {
  const auto reel = std::make_shared<RenderedReel>(script_of(FirstRest::until_rendered));
  while (!reel->has(0, reel->order().size())) std::this_thread::yield();
  ReelPlayer one_by_one(reel);
  for (std::size_t steps = 0; steps < 3 * reel->order().size(); ++steps) {
    ReelPlayer at_once(reel);
    at_once.advance(steps);
    ASSERT_EQ(at_once.frame(), one_by_one.frame()) << steps;
    ASSERT_EQ(at_once.has_shown_enough(), one_by_one.has_shown_enough()) << steps;
    one_by_one.advance();
  }
}

TEST(RenderedReel, EndsAtOnceAndReportsFailures) {
  const auto failing = [](double) { throw WorldError("out of paint"); };
  const RenderedReel reel(script_of(FirstRest::none), failing);
  try {
    static_cast<void>(
        reel.wait_for(reel.order().size() / 2, RenderedReel::Clock::now() + long_enough));
    ADD_FAILURE() << "rendered in spite of the failure";
  } catch (const WorldError& error) {
    EXPECT_STREQ(error.what(), "out of paint");
  }

  ReelScript empty = script_of(FirstRest::none);
  empty.order.clear();
  EXPECT_THROW(RenderedReel{empty}, Error);
}

}  // namespace
}  // namespace slipstream
