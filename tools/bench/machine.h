#pragma once

#include <string>

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

}  // namespace slipstream
