#include "slipstream/performance/timing.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <optional>

#include <tbb/global_control.h>

namespace slipstream {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// The value below which that share of them lies; sorts a part of them.
double quantile(std::vector<double>& values, double share) {
  const auto place = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), values.begin() + place, values.end());
  return values[static_cast<std::size_t>(place)];
}

}  // namespace

std::vector<Timing> timed(const std::vector<BenchRow>& rows, const TimingSettings& settings,
                          const std::function<void()>& after_row) {
  std::vector<std::vector<double>> milliseconds(rows.size());
  for (int round = 0; round < settings.rounds; ++round) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                        static_cast<std::size_t>(rows[i].threads));
      rows[i].run();  // brings its data back into the cache after the other rows
      const Clock::time_point start = Clock::now();
      do {
        const Clock::time_point begun = Clock::now();
        rows[i].run();
        milliseconds[i].push_back(1e3 * seconds_since(begun));
      } while (seconds_since(start) < settings.row_seconds);
      after_row();
    }
  }
  std::vector<Timing> timings;
  for (std::vector<double>& of_row : milliseconds) {
    timings.push_back({.median = quantile(of_row, 0.5),
                       .lower_quartile = quantile(of_row, 0.25),
                       .upper_quartile = quantile(of_row, 0.75),
                       .runs = static_cast<int>(of_row.size())});
  }
  return timings;
}

double streaming_bandwidth() {
  constexpr std::size_t count = 48 << 20;  // floats: past any cache of one core
  std::vector<float> a(count, 1), b(count, 2);
  double best = 0;
  for (int i = 0; i < 5; ++i) {
    const Clock::time_point start = Clock::now();
    for (std::size_t k = 0; k < count; ++k) a[k] += b[k];
    best = std::max(best, 3.0 * sizeof(float) * count / seconds_since(start));
  }
  return best;
}

}  // namespace slipstream
