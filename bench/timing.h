#pragma once

#include <functional>
#include <string>
#include <vector>

namespace slipstream {

/// What the times are of.
struct BenchMachine {
  std::string processor;
  std::string vectors;   ///< the vector instructions in use
  double bandwidth = 0;  ///< bytes per second that one thread reads and writes when it adds one
                         ///< large array to another
};

/// This one; the bandwidth is measured.
BenchMachine bench_machine();

/// One thing to time. Everything that it needs stands in memory; `run` does it once.
struct BenchRow {
  std::string name;
  int steps = 0;
  int width = 0;
  int height = 0;
  int threads = 1;
  int scans = 1;  ///< of one run; times are for each
  /// Bytes that one pixel reads and writes, tables and output included, when each is touched once;
  /// 0 where that says nothing.
  double bytes_per_pixel = 0;
  bool is_coding = false;      ///< held against `fused` of three steps in a table of its own
  bool is_beside_gpu = false;  ///< of a GPU, or held against one; the clock on the wall counts
  std::function<void()> run;

  [[nodiscard]] double pixels() const { return static_cast<double>(width) * height; }
};

/// Milliseconds of one scan, of the thread's own time for rows of one thread, else by the clock on
/// the wall: the median, and between which the middle half of the runs lies.
struct Timing {
  double median = 0;
  double lower_quartile = 0;
  double upper_quartile = 0;
  int runs = 0;
};

struct TimedRow {
  BenchRow row;
  Timing timing;

  [[nodiscard]] double runs_per_second() const { return 1e3 / timing.median; }
  [[nodiscard]] double bytes_per_second() const {
    return row.bytes_per_pixel * row.pixels() * runs_per_second();
  }
};

struct TimingSettings {
  int rounds = 7;             ///< over all rows, so that a slow while of the machine meets all
  double row_seconds = 0.05;  ///< at least so long for each row in each round
};

/// Each row with its timing, in order. `after_row` is called after every row of every round.
std::vector<TimedRow> timed(const std::vector<BenchRow>& rows, const TimingSettings& settings,
                            const std::function<void()>& after_row);

}  // namespace slipstream
