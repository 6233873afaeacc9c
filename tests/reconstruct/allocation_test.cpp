// In steady state the fused pass allocates nothing.
#include <random>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "slipstream/reconstruct/fused_reconstructor.h"
#include "slipstream/simulate/named_scenes.h"
#include "tests/counted_allocations.h"

namespace slipstream {
namespace {

TEST(FusedReconstructor, AllocatesNothingOnceItsOutputHasBeenUsed) {
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const Size size{96, 64};
  for (const Strategy& strategy :
       {Strategy(PhaseMeasuring{.steps = 5, .frequency = 1}), Strategy(DualFrequency{.steps = 3}),
        make_strategy("pcmp", {{"steps", 4}})}) {
    const auto reconstruct = FusedReconstructor::make(example_scanner(size), strategy, Axis::x, {});
    const auto count = static_cast<std::size_t>(frame_count(strategy));
    std::vector<Image<std::uint8_t>> images(count, Image<std::uint8_t>(size));
    std::mt19937 random(5);
    for (Image<std::uint8_t>& image : images) {
      for (std::uint8_t& pixel : image) pixel = static_cast<std::uint8_t>(random());
    }
    const Frames<std::uint8_t> frames(images.begin(), images.end());
    FusedCloud cloud;
    (*reconstruct)(frames, cloud);
    const long before = allocations;
    (*reconstruct)(frames, cloud);
    EXPECT_EQ(allocations, before);
  }
}

}  // namespace
}  // namespace slipstream
