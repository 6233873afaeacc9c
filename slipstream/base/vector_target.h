#pragma once

#include <string>
#include <vector>

namespace slipstream {

/// The vector instruction sets that the kernels were compiled for and this machine has, best first:
/// "AVX3" (AVX-512), "AVX2", "SSE4", "NEON", and last one that every machine has.
std::vector<std::string> vector_targets();

/// While it lives the kernels use that target alone, in the whole process: for tests and
/// measurements. Throws Error for a target that is not there.
class OnlyVectorTarget {
 public:
  explicit OnlyVectorTarget(const std::string& name);
  ~OnlyVectorTarget();
  OnlyVectorTarget(const OnlyVectorTarget&) = delete;
  OnlyVectorTarget& operator=(const OnlyVectorTarget&) = delete;
};

}  // namespace slipstream
