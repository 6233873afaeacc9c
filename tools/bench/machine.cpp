#include "tools/bench/machine.h"

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <fstream>
#include <vector>

#include "slipstream/base/vector_target.h"

namespace slipstream {
namespace {

std::string processor_name() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("model name")) return line.substr(line.find(':') + 2);
  }
  return "unknown";
}

double streaming_bandwidth() {
  using Clock = std::chrono::steady_clock;
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

}  // namespace slipstream
