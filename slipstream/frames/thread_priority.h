#pragma once

#include <cstdint>

#ifdef __linux__
#include <pthread.h>
#include <sched.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>
#endif

namespace slipstream {

/// The calling thread gets what time the others of the program leave. Called once. Nothing is
/// changed outside Linux, where this would be of the whole program.
inline void let_others_go_first() {
#ifdef __linux__
  static_cast<void>(::setpriority(PRIO_PROCESS, 0, ::getpriority(PRIO_PROCESS, 0) + 10));
#endif
}

/// The calling thread works for a moment at a time and is to begin at once when it wakes up: it
/// goes before all that computes where the system allows it (`ulimit -r`), else, from Linux 6.12
/// on, before what has had its share.
inline void go_when_woken() {
#ifdef __linux__
  const sched_param first{.sched_priority = 1};
  if (::pthread_setschedparam(::pthread_self(), SCHED_RR, &first) == 0) return;
  struct {  // the system's sched_attr, whose header does not go with the library's
    std::uint32_t size = 48, policy = SCHED_OTHER;
    std::uint64_t flags = 0;
    std::int32_t nice = ::getpriority(PRIO_PROCESS, 0);
    std::uint32_t priority = 0;
    std::uint64_t slice = 100'000, deadline = 0, period = 0;  // ns, the least
  } share;
  static_assert(sizeof share == 48);
  static_cast<void>(::syscall(SYS_sched_setattr, 0, &share, 0));
#endif
}

}  // namespace slipstream
