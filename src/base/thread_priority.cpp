#include "base/thread_priority.h"

#ifdef __linux__

#include <cstdint>

#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

void slipstream::let_others_go_first() {
  static_cast<void>(::setpriority(PRIO_PROCESS, 0, ::getpriority(PRIO_PROCESS, 0) + 10));
}

void slipstream::go_when_woken() {
  // Real time, if the system allows it.
  const sched_param first{.sched_priority = 1};
  if (::pthread_setschedparam(::pthread_self(), SCHED_RR, &first) == 0) return;

  // Otherwise the shortest time slice: the scheduler runs such a thread sooner.
  struct {  // the kernel's sched_attr; libc headers do not define it
    std::uint32_t size = 48, policy = SCHED_OTHER;
    std::uint64_t flags = 0;
    std::int32_t nice = ::getpriority(PRIO_PROCESS, 0);
    std::uint32_t priority = 0;
    std::uint64_t slice = 100'000, deadline = 0, period = 0;  // ns; 100 us is the shortest slice
  } share;

  static_assert(sizeof share == 48);
  static_cast<void>(::syscall(SYS_sched_setattr, 0, &share, 0));
}

#else

void slipstream::let_others_go_first() {}
void slipstream::go_when_woken() {}

#endif
