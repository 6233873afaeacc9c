// Memory use does not grow with running time.
#include <fstream>

#include <gtest/gtest.h>
#include <unistd.h>

#include "slipstream/live_pipeline.h"
#include "tests/counted_allocations.h"
#include "tests/live/scripted_source.h"
#include "tests/live/virtual_loop.h"

namespace slipstream::live_memory_test {

#if defined(__SANITIZE_THREAD__) || defined(__SANITIZE_ADDRESS__)
constexpr bool sanitized = true;  // sanitizers add memory and time
#else
constexpr bool sanitized = false;
#endif
constexpr std::uint64_t frames = sanitized ? 5'000 : 100'000;

long resident_kilobytes() {
  std::ifstream file("/proc/self/statm");
  long size = 0, resident = 0;
  file >> size >> resident;
  return resident * ::sysconf(_SC_PAGESIZE) / 1024;
}

TEST(LiveMemory, LivePipelineTakesNoMoreMemoryTheLongerItRuns) {
  for (const Strategy& strategy : {Strategy(PhaseMeasuring{.steps = 4, .frequency = 1}),
                                   Strategy(DualFrequency{.steps = 3})}) {
    std::uint64_t clouds = 0;
    long allocations_after = 0, resident_after = 0, allocations_in_the_end = 0;
    const std::uint64_t warm = frames / 10;
    const std::uint64_t last = frames / 2 - static_cast<std::uint64_t>(frame_count(strategy)) + 1;
    LivePipeline pipeline(
        std::make_unique<VirtualCamera>(frames_of(strategy)),
        {.scanner = example_scanner({64, 48}), .sequence = {.strategy = strategy}},
        {.most_frames = frames / 2, .on_cloud = [&](const Pooled<LiveCloud>&) {
           ++clouds;
           if (clouds == warm) {
             resident_after = resident_kilobytes();
             allocations_after = allocations;
           }
           if (clouds == last) allocations_in_the_end = allocations;
         }});
    run_to_its_end(pipeline);
    EXPECT_EQ(clouds, last);
    EXPECT_EQ(allocations_in_the_end, allocations_after);
    // Thread stacks may grow a little.
    if (!sanitized) EXPECT_LE(resident_kilobytes(), resident_after + 1024);
  }
}

}  // namespace slipstream::live_memory_test
