#pragma once

#include <sys/resource.h>

namespace slipstream {

/// The calling thread gets what time the others of the program leave. Called once. Nothing is
/// changed outside Linux, where this would be of the whole program.
inline void let_others_go_first() {
#ifdef __linux__
  static_cast<void>(::setpriority(PRIO_PROCESS, 0, ::getpriority(PRIO_PROCESS, 0) + 10));
#endif
}

}  // namespace slipstream
