// Loaded before all others into the program, fails one call of the world's: the n-th of malloc and
// its kin (operator new calls it), open, write, close, rename, fsync or pthread_create. It counts
// from the first line of main until main returns, but not while GDAL registers its formats, which
// OpenCV has it do before the first picture: how libraries start and end is not the program's.
// SLIPSTREAM_FAULT is the call's place in that list, from 0, SLIPSTREAM_FAULT_AT is n, from 1, and
// the file SLIPSTREAM_FAULT_TOLD holds numbers: the faults made, then how many calls of each.
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdlib>

#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <unistd.h>

extern "C" {
void* __libc_malloc(std::size_t size);
void* __libc_calloc(std::size_t count, std::size_t size);
void* __libc_realloc(void* memory, std::size_t size);
void* __libc_memalign(std::size_t alignment, std::size_t size);
}

namespace {

enum Call { of_malloc, of_open, of_write, of_close, of_rename, of_fsync, of_thread, call_count };

struct Told {
  std::atomic<std::uint64_t> faults;
  std::atomic<std::uint64_t> calls[call_count];
};

unsigned long failing = call_count;
std::uint64_t fails_at = 0;
Told* told = nullptr;
std::atomic<bool> armed = false;

/// Whether this call is the one.
bool fails(Call call) {
  if (!armed.load(std::memory_order_relaxed)) return false;
  if (told->calls[call].fetch_add(1) + 1 != fails_at || call != failing) return false;
  ++told->faults;
  return true;
}

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

int (*program_main)(int, char**, char**) = nullptr;

int main_with_faults(int argc, char** argv, char** environment) {
  if (const char* const call = std::getenv("SLIPSTREAM_FAULT")) {
    failing = std::strtoul(call, nullptr, 10);
  }
  if (const char* const at = std::getenv("SLIPSTREAM_FAULT_AT")) {
    fails_at = std::strtoull(at, nullptr, 10);
  }
  if (const char* const file = std::getenv("SLIPSTREAM_FAULT_TOLD")) {
    const int descriptor = ::open(file, O_RDWR | O_CLOEXEC);
    void* const memory =
        ::mmap(nullptr, sizeof(Told), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    ::close(descriptor);
    if (memory != MAP_FAILED) told = static_cast<Told*>(memory);
  }
  ::unsetenv("LD_PRELOAD");
  armed = told != nullptr;
  const int code = program_main(argc, argv, environment);
  armed = false;
  return code;
}

}  // namespace

extern "C" {

int __libc_start_main(int (*main)(int, char**, char**), int argc, char** argv, void (*init)(),
                      void (*fini)(), void (*loader_fini)(), void* stack_end) {
  program_main = main;
  return next<decltype(&__libc_start_main)>("__libc_start_main")(main_with_faults, argc, argv, init,
                                                                 fini, loader_fini, stack_end);
}

void GDALAllRegister() {
  const bool was_armed = armed.exchange(false);
  if (const auto all = next<void (*)()>("GDALAllRegister")) all();
  armed = was_armed;
}

void* malloc(std::size_t size) {
  if (!fails(of_malloc)) return __libc_malloc(size);
  errno = ENOMEM;
  return nullptr;
}

void* calloc(std::size_t count, std::size_t size) {
  if (!fails(of_malloc)) return __libc_calloc(count, size);
  errno = ENOMEM;
  return nullptr;
}

void* realloc(void* memory, std::size_t size) {
  if (!fails(of_malloc)) return __libc_realloc(memory, size);
  errno = ENOMEM;
  return nullptr;
}

void* aligned_alloc(std::size_t alignment, std::size_t size) {
  if (!fails(of_malloc)) return __libc_memalign(alignment, size);
  errno = ENOMEM;
  return nullptr;
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  *memory = fails(of_malloc) ? nullptr : __libc_memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}

int open(const char* path, int flags, ...) {
  std::va_list values;
  va_start(values, flags);
  const mode_t mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(values, mode_t) : 0;
  va_end(values);
  if (!fails(of_open)) return static_cast<int>(::syscall(SYS_openat, AT_FDCWD, path, flags, mode));
  errno = EMFILE;
  return -1;
}

ssize_t write(int descriptor, const void* bytes, std::size_t size) {
  if (!fails(of_write)) return ::syscall(SYS_write, descriptor, bytes, size);
  errno = ENOSPC;
  return -1;
}

int close(int descriptor) {
  const bool fault = fails(of_close);  // the descriptor is closed all the same
  const int result = static_cast<int>(::syscall(SYS_close, descriptor));
  if (!fault) return result;
  errno = EIO;
  return -1;
}

int rename(const char* from, const char* to) noexcept {
  if (!fails(of_rename)) return static_cast<int>(::syscall(SYS_rename, from, to));
  errno = EIO;
  return -1;
}

int fsync(int descriptor) {
  if (!fails(of_fsync)) return static_cast<int>(::syscall(SYS_fsync, descriptor));
  errno = EIO;
  return -1;
}

int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*),
                   void* argument) noexcept {
  if (fails(of_thread)) return EAGAIN;
  static const auto create = next<decltype(&pthread_create)>("pthread_create");
  return create(thread, attributes, start, argument);
}
}
