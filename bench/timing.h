#pragma once

#include <functional>
#include <string>
#include <vector>

namespace slipstream {

/// Machine on which the times are measured.
struct BenchMachine {
  std::string processor;
  std::string vectors;   ///< the vector instructions in use
  double bandwidth = 0;  ///< bytes per second that one thread reads and writes when it adds one
                         ///< large array to another
};

/// Describes this machine; measures the bandwidth.
BenchMachine bench_machine();

/// One operation to time. Its inputs are in memory; `run` does it once.
struct BenchRow {
  std::string name;
  int steps = 0;
  int width = 0;
  int height = 0;
  int threads = 1;
  int scans = 1;  ///< per run; times are per scan
  /// Bytes read and written per pixel, with tables and output, each touched once; 0 if meaningless.
  double bytes_per_pixel = 0;
  bool is_coding = false;      ///< compared with `fused` at three steps, in a separate table
  bool is_beside_gpu = false;  ///< on a GPU or compared with one; wall-clock time counts
  std::function<void()> run;

  [[nodiscard]] double pixels() const { return static_cast<double>(width) * height; }
};

/// Milliseconds per scan: median and quartiles. CPU time on one thread, else wall-clock time.
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
  int rounds = 7;             ///< over all rows, so that a slow phase of the machine affects all
  double row_seconds = 0.05;  ///< minimum for each row in each round
};

/// Times each row, in order. Calls `after_row` after every row of every round.
std::vector<TimedRow> timed(const std::vector<BenchRow>& rows, const TimingSettings& settings,
                            const std::function<void()>& after_row);

}  // namespace slipstream
