#include "bench/bench_report.h"

#include <gtest/gtest.h>

namespace slipstream::bench_report_test {

TimedRow row(std::string name, int steps, double milliseconds, int width = 640, int threads = 1) {
  return {{.name = std::move(name),
           .steps = steps,
           .width = width,
           .height = width * 3 / 4,
           .threads = threads,
           .run = {}},
          {.median = milliseconds, .runs = 1}};
}

TimedRow coding(std::string name, int steps, double milliseconds) {
  TimedRow timed = row(std::move(name), steps, milliseconds);
  timed.row.is_coding = true;
  return timed;
}

TEST(BenchReport, BenchRatiosAreOfTheSameNAndSize) {
  const BenchRatios ratios = bench_ratios(
      {row("lut", 3, 6), row("fused", 3, 2), row("engine", 3, 2.5), row("engine", 4, 9),
       coding("pcmp-5", 5, 5), row("fused", 3, 1, 640, 2), row("fused", 3, 12, 1280)});
  EXPECT_EQ(ratios.over_fused,
            (std::map<std::string, double>{{"lut", 3}, {"engine", 1.25}, {"pcmp-5", 2.5}}));
  EXPECT_EQ(ratios.threads, 2);
  EXPECT_EQ(ratios.largest_per_pixel, 1.5);
}

TEST(BenchReport, BenchRatiosAreNoneWithoutTheFusedPass) {
  const BenchRatios ratios = bench_ratios({row("lut", 3, 6), row("fused", 4, 2)});
  EXPECT_TRUE(ratios.over_fused.empty());
  EXPECT_FALSE(ratios.threads || ratios.largest_per_pixel);
}

TEST(BenchReport, TellsEveryRowAndRatio) {
  BenchReport report{.machine = {.processor = "a processor", .vectors = "AVX2", .bandwidth = 1e10},
                     .rows = {row("lut", 3, 6), row("fused", 3, 2), row("engine", 3, 2.5),
                              row("general", 4, 7), coding("pcmp-5", 5, 5)}};
  report.ratios = bench_ratios(report.rows);
  const std::string text = text_of(report.machine) + text_of(report);
  for (const char* words :
       {"a processor, vectors: AVX2", "10.0 GB/s", "N = 3", "N = 4", "general", "7.000 ms",
        "pcmp-5", "640x480", "lut          3.0 times as fast", "alone: 1.25", " 492/s"}) {
    EXPECT_NE(text.find(words), std::string::npos) << words << " in\n" << text;
  }
  EXPECT_EQ(text.find("N = 5"), std::string::npos) << "of PCMP alone\n" << text;
}

TEST(BenchReport, HoldsTheGpuBesideTheFusedPass) {
  BenchReport report{.rows = {row("gpu-cloud", 3, 2), row("fused-cloud", 3, 3),
                              row("gpu-resident", 3, 0.5), row("gpu-cloud", 3, 10, 1280)}};
  for (TimedRow& timed : report.rows) timed.row.is_beside_gpu = true;
  const std::string text = text_of(report);
  for (const char* words : {"1.50", "6.00", "640x480", "1280x960"}) {
    EXPECT_NE(text.find(words), std::string::npos) << words << " in\n" << text;
  }
  EXPECT_EQ(text.find("fused-cloud"), std::string::npos) << text;
}

}  // namespace slipstream::bench_report_test
