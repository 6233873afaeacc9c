// In place of oneTBB's header, for tests that limit threads: plain threads have no limit.
#pragma once

#include <cstddef>

namespace tbb {

struct global_control {
  enum parameter { max_allowed_parallelism };
  global_control(parameter /*what*/, std::size_t /*most*/) {}
};

}  // namespace tbb
