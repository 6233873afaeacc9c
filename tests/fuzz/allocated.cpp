#include "tests/fuzz/allocated.h"

#include <atomic>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SLIPSTREAM_SANITIZED
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SLIPSTREAM_SANITIZED
#endif
#endif

namespace slipstream {
namespace {

std::atomic<std::uint64_t> allocated = 0;

void count_allocation(std::size_t bytes) {
  allocated.fetch_add(bytes, std::memory_order_relaxed);
}

}  // namespace

std::uint64_t allocated_bytes() {
  return allocated.load(std::memory_order_relaxed);
}

}  // namespace slipstream

#ifdef SLIPSTREAM_SANITIZED

// Sanitizers have an allocator of their own, which calls hooks.
extern "C" int __sanitizer_install_malloc_and_free_hooks(
    void (*allocates)(const volatile void* memory, std::size_t bytes),
    void (*frees)(const volatile void* memory));

namespace slipstream {
namespace {

const int counts_allocations = __sanitizer_install_malloc_and_free_hooks(
    [](const volatile void*, std::size_t bytes) { count_allocation(bytes); },
    [](const volatile void*) {});

}  // namespace
}  // namespace slipstream

#else

// The program's own functions come before those of the C library, also for its libraries.
extern "C" {

void* __libc_malloc(std::size_t bytes);
void* __libc_calloc(std::size_t count, std::size_t bytes);
void* __libc_realloc(void* memory, std::size_t bytes);
void* __libc_memalign(std::size_t alignment, std::size_t bytes);

__attribute__((visibility("default"))) void* malloc(std::size_t bytes) noexcept {
  slipstream::count_allocation(bytes);
  return __libc_malloc(bytes);
}

__attribute__((visibility("default"))) void* calloc(std::size_t count, std::size_t bytes) noexcept {
  slipstream::count_allocation(count * bytes);
  return __libc_calloc(count, bytes);
}

__attribute__((visibility("default"))) void* realloc(void* memory, std::size_t bytes) noexcept {
  slipstream::count_allocation(bytes);
  return __libc_realloc(memory, bytes);
}

__attribute__((visibility("default"))) void* aligned_alloc(std::size_t alignment,
                                                           std::size_t bytes) noexcept {
  slipstream::count_allocation(bytes);
  return __libc_memalign(alignment, bytes);
}

__attribute__((visibility("default"))) int posix_memalign(void** memory, std::size_t alignment,
                                                          std::size_t bytes) noexcept {
  slipstream::count_allocation(bytes);
  void* const got = __libc_memalign(alignment, bytes);
  if (got == nullptr) return ENOMEM;
  *memory = got;
  return 0;
}

}  // extern "C"

#endif
