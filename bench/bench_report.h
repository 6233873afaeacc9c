#pragma once

#include <array>
#include <map>
#include <optional>
#include <string_view>

#include "bench/timing.h"

namespace slipstream {

/// What the fused pass is held against, on one thread at N = 3 and 640x480 where nothing else is
/// said. What has no row has no ratio.
struct BenchRatios {
  /// Time of the row of that name over the time of `fused`.
  std::map<std::string, double> over_fused{};
  std::optional<double>
      largest_per_pixel{};          ///< time per pixel of the largest picture over 640x480
  std::optional<double> threads{};  ///< time on one thread over that on all
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
  std::string gpu{};  ///< and its driver; of gpu_rows
  std::vector<TimedRow> rows{};
  BenchRatios ratios{};
};

/// What a terminal shows of the machine, a line each.
std::string text_of(const BenchMachine& machine);

/// And of the times: tables, ratios, published marks.
std::string text_of(const BenchReport& report);

}  // namespace slipstream
