#pragma once

#include <string>
#include <vector>

namespace slipstream {

/// Vector instruction sets that the kernels were compiled for and this machine supports, best
/// first: "AVX3" (AVX-512), "AVX2", "SSE4", "NEON", and last the baseline.
std::vector<std::string> vector_targets();

/// While it lives, all kernels of the process use only that target: for tests and measurements.
/// Throws Error if the target is not available.
class OnlyVectorTarget {
 public:
  explicit OnlyVectorTarget(const std::string& name);
  ~OnlyVectorTarget();
  OnlyVectorTarget(const OnlyVectorTarget&) = delete;
  OnlyVectorTarget& operator=(const OnlyVectorTarget&) = delete;
};

}  // namespace slipstream
