#include "slipstream/base/parallel_rows.h"

#include <cstdint>

#ifdef __linux__
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

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
// hand-over between its threads as a race. Plain threads let it check the bodies.
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

void let_others_go_first() {
#ifdef __linux__
  static_cast<void>(::setpriority(PRIO_PROCESS, 0, ::getpriority(PRIO_PROCESS, 0) + 10));
#endif
}

void go_when_woken() {
#ifdef __linux__
  const sched_param first{.sched_priority = 1};
  if (::pthread_setschedparam(::pthread_self(), SCHED_RR, &first) == 0) return;
  struct {  // the kernel's sched_attr; libc headers do not define it
    std::uint32_t size = 48, policy = SCHED_OTHER;
    std::uint64_t flags = 0;
    std::int32_t nice = ::getpriority(PRIO_PROCESS, 0);
    std::uint32_t priority = 0;
    std::uint64_t slice = 100'000, deadline = 0, period = 0;  // ns; 100 us is the shortest slice
  } share;
  static_assert(sizeof share == 48);
  static_cast<void>(::syscall(SYS_sched_setattr, 0, &share, 0));
#endif
}

}  // namespace slipstream
