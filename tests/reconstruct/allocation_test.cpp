// In steady state an engine allocates nothing.
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "tests/counted_allocations.h"
#include "tests/own_strategies.h"

namespace slipstream::allocation_test {

const std::vector<Strategy> strategies{PhaseMeasuring{.steps = 5, .frequency = 1},
                                       DualFrequency{.steps = 3},
                                       make_strategy("pcmp", {{"steps", 3}}),
                                       make_strategy("pcmp", {{"steps", 4}}),
                                       make_strategy("pcmp", {{"steps", 5}}),
                                       CosineSineMean{},
                                       ThreeFrequencies{},
                                       ThreeFrequencies{.first = 36, .second = 1, .third = 6}};

template <class Pixel>
std::vector<Image<Pixel>> noise(int count, Size size) {
  std::vector<Image<Pixel>> images(static_cast<std::size_t>(count), Image<Pixel>(size));
  std::mt19937 random(5);
  for (Image<Pixel>& image : images) {
    for (Pixel& pixel : image) pixel = static_cast<Pixel>(random());
  }
  return images;
}

/// Calls `make` once, and says what it allocates after that.
template <class Make>
long allocated_again(const Make& make) {
  make();
  const long before = allocations;
  for (int call = 0; call < 3; ++call) make();
  return allocations - before;
}

void expect_none(const Strategy& strategy, Size size, const FrameViews& frames) {
  SCOPED_TRACE(testing::Message() << strategy.name() << ", " << frames.bits() << " bits");
  Engine engine(example_scanner(size), {.strategy = strategy}, {.engine = EngineKind::fused});
  ASSERT_EQ(engine.backend_for(frames), "fused");
  Cloud cloud;
  Depth depth;
  Maps maps;
  EXPECT_EQ(allocated_again([&] { engine.cloud(frames, cloud); }), 0);
  EXPECT_EQ(allocated_again([&] { engine.depth(frames, depth); }), 0);
  Image<std::uint16_t> numbers;
  EXPECT_EQ(allocated_again([&] { engine.depth(frames, DepthScale(), numbers); }), 0);
  EXPECT_EQ(allocated_again([&] { engine.maps(frames, maps); }), 0);
  EXPECT_EQ(allocated_again([&] { engine.cloud_and_maps(frames, cloud, maps); }), 0);
  // In turns, each with its own output, as a viewer asks.
  EXPECT_EQ(allocated_again([&] {
              engine.cloud(frames, cloud);
              engine.maps(frames, maps);
              engine.depth(frames, depth);
            }),
            0);
}

TEST(Allocation, EngineAllocatesNothingOnceItsOutputHasBeenUsed) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Size size{96, 64};
  for (const Strategy& strategy : strategies) {
    const auto bytes = noise<std::uint8_t>(frame_count(strategy), size);
    const auto words = noise<std::uint16_t>(frame_count(strategy), size);
    expect_none(strategy, size, Frames<std::uint8_t>(bytes.begin(), bytes.end()));
    expect_none(strategy, size, {Frames<std::uint16_t>(words.begin(), words.end()), 16});
  }
}

/// Building one allocates tables for every ray of the camera.
TEST(Allocation, EngineCopiesShareTheTables) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  for (const Strategy& strategy : strategies) {
    const long before_first = allocations;
    const Engine engine(example_scanner({96, 64}), {.strategy = strategy});
    const long of_first = allocations - before_first;
    const long before_copy = allocations;
    const Engine copy(engine);
    EXPECT_LE(allocations - before_copy, 2);
    EXPECT_GT(of_first, 20);
    EXPECT_EQ(&copy.setup(), &engine.setup());
  }
}

}  // namespace slipstream::allocation_test
