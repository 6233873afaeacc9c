// However long it runs, it takes no more memory.
#include <atomic>
#include <cstdlib>
#include <fstream>
#include <new>

#include <gtest/gtest.h>
#include <unistd.h>

#include "slipstream/live/live_pipeline.h"
#include "tests/live/virtual_loop.h"

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

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
constexpr std::uint64_t frames = 5'000;
#else
constexpr std::uint64_t frames = 100'000;
#endif

long resident_kilobytes() {
  std::ifstream file("/proc/self/statm");
  long size = 0, resident = 0;
  file >> size >> resident;
  return resident * ::sysconf(_SC_PAGESIZE) / 1024;
}

TEST(LivePipeline, takes_no_more_memory_the_longer_it_runs) {
  for (const Strategy& strategy : {Strategy(PhaseMeasuring{.steps = 4, .frequency = 1}),
                                   Strategy(DualFrequency{.steps = 3})}) {
    std::uint64_t clouds = 0;
    long allocations_after = 0, resident_after = 0, allocations_in_the_end = 0;
    const std::uint64_t warm = frames / 10;
    const std::uint64_t last = frames / 2 - static_cast<std::uint64_t>(frame_count(strategy)) + 1;
    LivePipeline pipeline(std::make_unique<VirtualCamera>(frames_of(strategy)),
                          {.scanner = example_scanner({64, 48}), .strategy = strategy},
                          {.most_frames = frames / 2, .on_cloud = [&](const Pooled<LiveCloud>&) {
                             ++clouds;
                             if (clouds == warm) {
                               resident_after = resident_kilobytes();
                               allocations_after = allocations;
                             }
                             if (clouds == last) allocations_in_the_end = allocations;
                           }});
    pipeline.start();
    while (pipeline.running()) ::usleep(1000);
    pipeline.stop();
    EXPECT_EQ(clouds, last);
    EXPECT_EQ(allocations_in_the_end, allocations_after);
    // A thread's stack may come to be touched a little deeper.
    EXPECT_LE(resident_kilobytes(), resident_after + 1024);
  }
}

}  // namespace
}  // namespace slipstream
