#include "base/parallel_rows.h"

#include <algorithm>

// The thread sanitizer cannot see inside oneTBB as distributions build it and reports every
// hand-over between its threads as a race. Plain threads let it check the bodies.
#if defined(SLIPSTREAM_TBB) && !defined(__SANITIZE_THREAD__)

#include <tbb/global_control.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

namespace slipstream {

int parallel_threads() {
  const auto allowed = static_cast<int>(
      tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
  return std::min(allowed, tbb::this_task_arena::max_concurrency());
}

void for_each_row(int height, const std::function<void(int row)>& body) {
  tbb::parallel_for(0, height, body);
}

}  // namespace slipstream

#else

#include <atomic>
#include <future>
#include <thread>
#include <vector>

namespace slipstream {

int parallel_threads() {
#ifdef __SANITIZE_THREAD__
  return 2;
#else
  static const unsigned known = std::thread::hardware_concurrency();  // 0 if unknown
  return std::max(1, static_cast<int>(known));
#endif
}

void for_each_row(int height, const std::function<void(int row)>& body) {
  // Each thread takes the next row until all are taken; an exception ends the others too.
  std::atomic<int> next_row = 0;
  const auto work = [&] {
    try {
      for (int row = next_row++; row < height; row = next_row++) body(row);
    } catch (...) {
      next_row = height;
      throw;
    }
  };

  // Their destructors wait, also after an exception.
  std::vector<std::future<void> > others(
      static_cast<std::size_t>(std::clamp(height, 1, parallel_threads()) - 1));

  // This thread works as well; get() rethrows.
  for (auto& other : others) other = std::async(std::launch::async, work);
  work();
  for (auto& other : others) other.get();
}

}  // namespace slipstream

#endif
