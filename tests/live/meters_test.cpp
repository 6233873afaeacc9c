#include <string>

#include <gtest/gtest.h>

#include "live/live_counters.h"
#include "slipstream/live_pipeline.h"

namespace slipstream::meters_test {
using namespace std::chrono_literals;

TEST(Meters, LatencyHistogramPercentilesAreWithinAStepAndTheMaximumIsExact) {
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

TEST(Meters, LatencyHistogramTakesWhateverItIsGiven) {
  LatencyHistogram histogram;
  histogram.add(-5ms);
  histogram.add(0ns);
  EXPECT_EQ(histogram.latency().max, 0);
  histogram.add(1h);
  EXPECT_DOUBLE_EQ(histogram.latency().max, 3.6e6);
  EXPECT_GE(histogram.latency().p99, 1e5);
}

TEST(Meters, StageMeterRateIsThatOfTheSecondBefore) {
  StageMeter meter;
  const auto start = StageMeter::Clock::now();
  for (int i = 0; i < 30; ++i) meter.done(start);
  EXPECT_EQ(meter.statistics(start + 3s).done, 30U);
  EXPECT_DOUBLE_EQ(meter.statistics(start + 10s).rate, 0);
  // Counted once their time slot has ended.
  EXPECT_DOUBLE_EQ(meter.statistics(start + 950ms).rate * 0.9, 30);
  EXPECT_DOUBLE_EQ(meter.statistics(start).rate, 0);
}

TEST(Meters, SequenceWatchCountsGapsAndTakesBackWhatComesLate) {
  SequenceWatch watch;
  EXPECT_TRUE(watch.look(5));
  EXPECT_TRUE(watch.look(6));
  EXPECT_FALSE(watch.look(6));
  EXPECT_TRUE(watch.look(10));
  EXPECT_EQ(watch.lost(), 3U);
  EXPECT_TRUE(watch.look(8));
  EXPECT_FALSE(watch.look(8));
  EXPECT_EQ(watch.lost(), 2U);
  EXPECT_TRUE(watch.look(1000));
  EXPECT_EQ(watch.lost(), 991U);
  EXPECT_TRUE(watch.look(0));
  EXPECT_EQ(watch.restarts(), 1U);
  EXPECT_TRUE(watch.look(1));
  EXPECT_EQ(watch.lost(), 991U);
}

TEST(Meters, SequenceWatchADamagedFrameIsLostOnce) {
  SequenceWatch watch;
  watch.look(0);
  watch.damaged();
  EXPECT_EQ(watch.lost(), 1U);
  watch.look(2);
  EXPECT_EQ(watch.lost(), 1U);
  watch.damaged();
  watch.look(3);
  EXPECT_EQ(watch.lost(), 2U);
}

Finding finding(const std::string& what, double value = 0) {
  return {.what = what, .evidence = {{"value", value}}, .subject = what};
}

TEST(Meters, FindingLogKnowsWhenWhatBeganAndEnded) {
  FindingLog log;
  log.replace({}, 3);
  EXPECT_TRUE(log.all().empty());
  log.replace({finding("a", 1)}, 7);
  log.replace({finding("a", 2), finding("b")}, 11);
  log.replace({finding("b")}, 15);
  EXPECT_EQ(log.current(), (std::vector<Finding>{finding("b")}));
  log.replace({finding("a", 3)}, 19);
  EXPECT_EQ(log.all(),
            (std::vector<LiveFinding>{
                {finding("a", 1), 7, 15}, {finding("b"), 11, 19}, {finding("a", 3), 19, {}}}));
  log.replace({}, 23);
  EXPECT_TRUE(log.current().empty());
  EXPECT_EQ(log.all().back().end, 23U);
}

TEST(Meters, FindingLogForgetsTheOldestThatHasEnded) {
  FindingLog log;
  for (std::uint64_t n = 0; n < 3 * FindingLog::most; ++n) {
    log.replace({finding("always"), finding(std::to_string(n))}, n);
  }
  EXPECT_EQ(log.all().size(), FindingLog::most);
  EXPECT_EQ(log.all().front().finding.what, "always");
  EXPECT_EQ(log.all().back().finding.what, std::to_string(3 * FindingLog::most - 1));
}

TEST(Meters, LiveStatisticsCountsOfWhatGoesWrongAreSaid) {
  const LiveStatistics statistics{
      .frames = {.lost = 5, .overwritten = 3}, .windows_lost = 2, .latency = {.p99 = 4}};
  std::string numbers, wrong;
  const auto note = [&](const char* name, const auto& value, const char* trouble = "") {
    if constexpr (requires { value + 1.0; }) {
      if (value != 0) numbers += name + std::string(" ");
      if (value != 0 && *trouble != '\0') wrong += trouble + std::string(", ");
    }
  };
  statistics.for_each_figure(note);
  statistics.frames.for_each_figure(note);
  statistics.latency.for_each_figure(note);
  EXPECT_EQ(numbers, "windows_lost lost overwritten p99 ");
  EXPECT_EQ(wrong, "scans lost, frames not used, ");
}

}  // namespace slipstream::meters_test
