#include "app/kept_memory.h"

#include <cstdint>
#include <cstdlib>

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

namespace slipstream::app {

void keep_memory() {
  constexpr int most = 32 << 20;  // more is refused
  constexpr std::uintptr_t page = 2 << 20;
  ::mallopt(M_MMAP_THRESHOLD, most);
  ::mallopt(M_TRIM_THRESHOLD, 16 * most);
  ::mallopt(M_TOP_PAD, 4 * most);
  ::mallopt(M_ARENA_MAX, 1);  // what one thread frees another takes
  void* const first = std::malloc(most / 2);
  const auto begin = (reinterpret_cast<std::uintptr_t>(first) + page - 1) / page * page,
             end = reinterpret_cast<std::uintptr_t>(::sbrk(0)) / page * page;
  if (first != nullptr && begin < end) {
    ::madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
  }
  std::free(first);
}

}  // namespace slipstream::app
