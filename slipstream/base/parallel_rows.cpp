#include "slipstream/base/parallel_rows.h"

#if defined(__SANITIZE_THREAD__)

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#else

#include <algorithm>

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#endif

namespace slipstream {

#if defined(__SANITIZE_THREAD__)

// The thread sanitizer cannot see inside oneTBB as distributions build it and reports every
// hand-over between its threads as a race. Threads that it sees let it judge the bodies.
int parallel_threads() {
  return 2;
}

void for_each_row(int height, const std::function<void(int row)>& body) {
  std::atomic<int> next_row = 0;
  std::exception_ptr first_failure;
  std::mutex failure_guard;
  const auto work = [&] {
    try {
      for (int row = next_row++; row < height; row = next_row++) body(row);
    } catch (...) {
      next_row = height;
      const std::scoped_lock lock(failure_guard);
      if (!first_failure) first_failure = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> threads(static_cast<std::size_t>(parallel_threads()));
    std::generate(threads.begin(), threads.end(), [&] { return std::jthread(work); });
  }
  if (first_failure) std::rethrow_exception(first_failure);
}

#else

int parallel_threads() {
  const auto allowed = static_cast<int>(
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
  return std::min(allowed, tbb::this_task_arena::max_concurrency());
}

void for_each_row(int height, const std::function<void(int row)>& body) {
  tbb::parallel_for(0, height, body);
}

#endif

}  // namespace slipstream
