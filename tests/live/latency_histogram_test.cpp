#include "slipstream/live/latency_histogram.h"

#include <gtest/gtest.h>

#include "slipstream/live/stage_meter.h"

namespace slipstream::latency_histogram_test {
using namespace std::chrono_literals;

TEST(LatencyHistogram, percentiles_are_within_a_step_and_the_maximum_is_exact) {
  LatencyHistogram histogram;
  EXPECT_EQ(histogram.latency().p99, 0);
  for (int i = 1; i <= 1000; ++i) histogram.add(i * 10us);
  const Latency latency = histogram.latency();
  EXPECT_GE(latency.p50, 5.0);
  EXPECT_LE(latency.p50, 5.0 * 1.042);
  EXPECT_GE(latency.p99, 9.9);
  EXPECT_LE(latency.p99, 10.0);
  EXPECT_DOUBLE_EQ(latency.max, 10.0);
}

TEST(LatencyHistogram, takes_whatever_it_is_given) {
  LatencyHistogram histogram;
  histogram.add(-5ms);
  histogram.add(0ns);
  EXPECT_EQ(histogram.latency().max, 0);
  histogram.add(1h);
  EXPECT_DOUBLE_EQ(histogram.latency().max, 3.6e6);
  EXPECT_GE(histogram.latency().p99, 1e5);
}

TEST(StageMeter, rate_is_that_of_the_second_before) {
  StageMeter meter;
  const auto start = StageMeter::Clock::now();
  for (int i = 0; i < 30; ++i) meter.done(start);
  EXPECT_EQ(meter.statistics(start + 3s).done, 30U);
  EXPECT_DOUBLE_EQ(meter.statistics(start + 10s).rate, 0);
  // As soon as the slot that they were counted in is over.
  EXPECT_DOUBLE_EQ(meter.statistics(start + 950ms).rate * 0.9, 30);
  EXPECT_DOUBLE_EQ(meter.statistics(start).rate, 0);
}

}  // namespace slipstream::latency_histogram_test
