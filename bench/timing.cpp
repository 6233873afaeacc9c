#include "bench/timing.h"

#include <algorithm>
#include <chrono>
#include <fstream>

#include <tbb/global_control.h>
#include <time.h>

#include "base/statistics.h"
#include "bench/vector_target.h"

namespace slipstream {
namespace {

using Clock = std::chrono::steady_clock;

double seconds_since(Clock::time_point start) {
  return std::chrono::duration<double>(Clock::now() - start).count();
}

/// Milliseconds of one scan: CPU time for one thread, which excludes other programs; wall-clock
/// time for several, since only that covers all of them.
double milliseconds_of(const BenchRow& row) {
  const auto own_time = [] {
    timespec now{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  };
  const Clock::time_point start = Clock::now();
  const double own_start = own_time();
  row.run();
  const bool own = row.threads == 1 && !row.is_beside_gpu;
  return 1e3 * (own ? own_time() - own_start : seconds_since(start)) / row.scans;
}

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

double streaming_bandwidth() {
  constexpr std::size_t count = 48 << 20;  // floats: past any cache of one core
  std::vector<float> a(count, 1), b(count, 2);
  double best = 0;
  for (int i = 0; i < 5; ++i) {
    const Clock::time_point start = Clock::now();
    for (std::size_t k = 0; k < count; ++k) a[k] += b[k];
    const std::chrono::duration<double> seconds = Clock::now() - start;
    best = std::max(best, 3.0 * sizeof(float) * count / seconds.count());
  }
  return best;
}

}  // namespace

BenchMachine bench_machine() {
  return {.processor = processor_name(),
          .vectors = vector_targets().front(),
          .bandwidth = streaming_bandwidth()};
}

std::vector<TimedRow> timed(const std::vector<BenchRow>& rows, const TimingSettings& settings,
                            const std::function<void()>& after_row) {
  std::vector<std::vector<double>> milliseconds(rows.size());
  for (int round = 0; round < std::max(settings.rounds, 1); ++round) {
    for (std::size_t i = 0; i < rows.size(); ++i) {
      const tbb::global_control threads(tbb::global_control::max_allowed_parallelism,
                                        static_cast<std::size_t>(rows[i].threads));
      rows[i].run();  // brings its data back into the cache after the other rows
      const Clock::time_point start = Clock::now();
      do {
        milliseconds[i].push_back(milliseconds_of(rows[i]));
      } while (seconds_since(start) < settings.row_seconds);
      after_row();
    }
  }
  std::vector<TimedRow> timings;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    std::vector<double>& of_row = milliseconds[i];
    timings.push_back({rows[i],
                       {.median = quantile(of_row, 0.5),
                        .lower_quartile = quantile(of_row, 0.25),
                        .upper_quartile = quantile(of_row, 0.75),
                        .runs = static_cast<int>(of_row.size())}});
  }
  return timings;
}

}  // namespace slipstream
