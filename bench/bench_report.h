#pragma once

#include <array>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "bench/timing.h"

namespace slipstream {

/// Speed of the fused pass compared with others, on one thread at N = 3 and 640x480 unless stated.
/// Rows that were not run have no ratio.
struct BenchRatios {
  /// Time of the row with that name divided by the time of `fused`.
  std::map<std::string, double> over_fused{};
  std::optional<double> largest_per_pixel{};  ///< time per pixel of the largest over 640x480
  std::optional<double> threads{};            ///< time on one thread over time on all
};

BenchRatios bench_ratios(const std::vector<TimedRow>& rows);

/// Published clouds per second, frames to cloud, 640x480, N = 3.
struct PublishedMark {
  std::string_view source;
  int fps;
};
inline constexpr std::array<PublishedMark, 2> published_marks{
    {{"Liu 2010, one core of 2008", 173}, {"the same author, Opt. Lett. 45(12), 2020", 492}}};

/// One run of `slipstream bench`.
struct BenchReport {
  BenchMachine machine{};
  std::string gpu{};  ///< GPU of gpu_rows, and its driver
  std::vector<TimedRow> rows{};
  BenchRatios ratios{};
};

/// Machine, for a terminal, one property per line.
std::string text_of(const BenchMachine& machine);

/// Times, for a terminal: tables, ratios, published marks.
std::string text_of(const BenchReport& report);

}  // namespace slipstream
