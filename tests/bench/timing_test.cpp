#include "bench/timing.h"

#include <gtest/gtest.h>

namespace slipstream::timing_test {

TEST(Timing, TimedCountsEveryRunOfEveryRow) {
  int runs = 0;
  const BenchRow row{.name = "counted", .run = [&runs] { ++runs; }};
  const std::vector<TimedRow> timings = timed({row, row}, {.rounds = 3, .row_seconds = 0}, [] {});
  ASSERT_EQ(timings.size(), 2U);
  EXPECT_EQ(timings[0].timing.runs, 3);
  EXPECT_EQ(runs, 12) << "one more each round to warm the cache";
  EXPECT_LE(timings[0].timing.lower_quartile, timings[0].timing.median);
  EXPECT_LE(timings[0].timing.median, timings[0].timing.upper_quartile);
}

}  // namespace slipstream::timing_test
