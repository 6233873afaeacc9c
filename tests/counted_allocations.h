#pragma once

// Counts what the whole program allocates: to be included by one source of it.
#include <atomic>
#include <cstddef>
#include <cstdlib>
#include <new>

namespace slipstream {

inline std::atomic<long> allocations = 0;

inline void* counted_allocation(std::size_t bytes, std::size_t alignment) {
  ++allocations;
  const std::size_t rounded = (bytes + alignment - 1) / alignment * alignment;
  if (void* memory = std::aligned_alloc(alignment, rounded == 0 ? alignment : rounded)) {
    return memory;
  }
  throw std::bad_alloc();
}

}  // namespace slipstream

// NOLINTBEGIN(misc-new-delete-overloads, misc-definitions-in-headers): sized forms come back to
// these, and one source includes them
void* operator new(std::size_t bytes) {
  return slipstream::counted_allocation(bytes, alignof(std::max_align_t));
}
void* operator new(std::size_t bytes, std::align_val_t alignment) {
  return slipstream::counted_allocation(bytes, static_cast<std::size_t>(alignment));
}
/// As sorting asks for its memory.
void* operator new(std::size_t bytes, const std::nothrow_t&) noexcept {
  try {
    return operator new(bytes);
  } catch (const std::bad_alloc&) {
    return nullptr;
  }
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::align_val_t) noexcept {
  std::free(memory);
}
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept {
  std::free(memory);
}
// NOLINTEND(misc-new-delete-overloads, misc-definitions-in-headers)
