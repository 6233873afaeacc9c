#pragma once

namespace slipstream {

/// Lowers the calling thread's priority below the program's other threads. Call it once per thread.
/// No effect outside Linux, where it would apply to the whole process.
void let_others_go_first();

/// Lets the calling thread start at once when it wakes, for threads that work briefly: real-time
/// priority if the system allows it (`ulimit -r`), else, from Linux 6.12 on, the shortest time
/// slice. No effect outside Linux.
void go_when_woken();

}  // namespace slipstream
