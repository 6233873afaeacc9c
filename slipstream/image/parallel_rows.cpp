#include "slipstream/image/parallel_rows.h"

#if defined(__SANITIZE_THREAD__)

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

#else

#include <tbb/parallel_for.h>

#endif

namespace slipstream {

#if defined(__SANITIZE_THREAD__)

// The thread sanitizer cannot see inside oneTBB as distributions build it and reports every
// hand-over between its threads as a race. Threads that it sees let it judge the bodies.
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
    std::vector<std::jthread> threads(2);
    std::generate(threads.begin(), threads.end(), [&] { return std::jthread(work); });
  }
  if (first_failure) std::rethrow_exception(first_failure);
}

#else

void for_each_row(int height, const std::function<void(int row)>& body) {
  tbb::parallel_for(0, height, body);
}

#endif

}  // namespace slipstream
