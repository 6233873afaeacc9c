// In steady state the fused pass allocates nothing.
#include <atomic>
#include <cstdlib>
#include <new>
#include <random>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "slipstream/reconstruct/fused_reconstructor.h"
#include "slipstream/simulate/named_scenes.h"

namespace {

std::atomic<long> allocations = 0;

void* counted(std::size_t bytes, std::size_t alignment) {
  ++allocations;
  const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  if (void* memory = std::aligned_alloc(alignment, rounded == 0 ? alignment : rounded)) {
    return memory;
  }
  throw std::bad_alloc();
}

}  // namespace

// NOLINTBEGIN(misc-new-delete-overloads): sized forms come back to these
void* operator new(std::size_t bytes) {
  return counted(bytes, alignof(std::max_align_t));
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return counted(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
// NOLINTEND(misc-new-delete-overloads)

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
