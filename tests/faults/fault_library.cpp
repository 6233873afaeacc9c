// Loaded before all others into the program, fails one call of the world's: the n-th of malloc and
// its kin (operator new calls it), open, write, close, rename, fsync or pthread_create. It counts
// from the first line of main until main returns, but not while GDAL registers its formats, which
// OpenCV has it do before the first picture: how libraries start and end is not the program's. Nor
// is how drivers of graphics do.
//
// The program is loaded once and forks at main for each run that fault_protocol.h asks for.
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <initializer_list>
#include <new>

#include <dlfcn.h>
#include <fcntl.h>
#include <link.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>
#include <unwind.h>

#include "tests/faults/fault_protocol.h"

namespace slipstream {
namespace {

FaultRequest wanted;
FaultRecord* record = nullptr;
std::atomic<bool> armed = false;
std::atomic<bool> is_drawing = false;
thread_local bool is_of_program = true;

template <class Function>
Function next(const char* name) {
  return reinterpret_cast<Function>(::dlsym(RTLD_NEXT, name));
}

struct Stack {
  int frames = 0;
  std::uint64_t hash = 1469598103934665603U;

  void add(std::uint64_t word) { hash = (hash ^ word) * 1099511628211U; }
};

/// The code of a frame as it is in its file, wherever that was loaded.
_Unwind_Reason_Code add_frame(_Unwind_Context* context, void* into) {
  auto& stack = *static_cast<Stack*>(into);
  const auto code = static_cast<std::uintptr_t>(::_Unwind_GetIP(context));
  dl_find_object object{};
  if (::_dl_find_object(reinterpret_cast<void*>(code), &object) == 0) {
    for (const char* name = object.dlfo_link_map->l_name; *name != 0; ++name) {
      stack.add(static_cast<unsigned char>(*name));
    }
    stack.add(code - object.dlfo_link_map->l_addr);
  }
  return ++stack.frames == frames_of_place ? _URC_END_OF_STACK : _URC_NO_REASON;
}

std::uint64_t place_of_call() {
  Stack stack;
  ::_Unwind_Backtrace(add_frame, &stack);
  return stack.hash;
}

/// Whether this call is the one.
[[gnu::noinline]] bool fails(FaultCall call) {
  if (!armed.load(std::memory_order_relaxed) || !is_of_program) return false;
  if (is_drawing && (call == of_malloc || call == of_thread)) return false;
  const std::uint64_t number = record->calls[call].fetch_add(1) + 1;
  const bool is_counted = call == of_malloc && wanted.at == 0 && number <= most_places;
  const bool is_failing = call == wanted.call && number == wanted.at;
  if (is_counted || is_failing) {
    const int error = errno;
    (is_failing ? record->place : record->places[number - 1]) = place_of_call();
    errno = error;
  }
  if (is_failing) ++record->faults;
  return is_failing;
}

/// After a call that was done.
void note(FaultCall call, int descriptor, std::uint64_t bytes = 0) {
  if (!armed.load(std::memory_order_relaxed)) return;
  const std::uint64_t number = record->events_made.fetch_add(1);
  if (number < most_events) record->events[number] = {call, descriptor, bytes};
}

/// What a library wakes its threads by (eventfd) is none, and takes whatever is written.
bool is_file(int descriptor) {
  struct stat found {};
  return ::fstat(descriptor, &found) == 0 && (found.st_mode & S_IFMT) != 0;
}

int (*program_main)(int, char**, char**) = nullptr;

/// The child that is to run on, or nothing more is asked for.
bool is_run_wanted(int requests, int answers) {
  while (::read(requests, &wanted, sizeof wanted) == sizeof wanted) {
    for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) {
      ::lseek(stream, 0, SEEK_SET);
      if (::ftruncate(stream, 0) != 0) return false;
    }
    const pid_t child = ::fork();
    if (child == 0) return true;
    record->process = child;
    int status = 0;
    ::waitpid(child, &status, 0);
    if (::write(answers, &status, sizeof status) != sizeof status) return false;
  }
  return false;
}

int main_with_faults(int argc, char** argv, char** environment) {
  const char* const folder = std::getenv("SLIPSTREAM_FAULTS_FROM");
  if (folder == nullptr || ::chdir(folder) != 0) return program_main(argc, argv, environment);
  ::unsetenv("LD_PRELOAD");
  const int file = ::open("record", O_RDWR | O_CLOEXEC);
  void* const memory =
      ::mmap(nullptr, sizeof(FaultRecord), PROT_READ | PROT_WRITE, MAP_SHARED, file, 0);
  if (memory == MAP_FAILED) return 125;
  record = static_cast<FaultRecord*>(memory);
  ::close(file);
  const int requests = ::open("requests", O_RDONLY | O_CLOEXEC);
  const int answers = ::open("answers", O_WRONLY | O_CLOEXEC);
  if (!is_run_wanted(requests, answers)) ::_exit(0);
  ::close(requests);
  ::close(answers);
  armed = true;
  const int code = program_main(argc, argv, environment);
  armed = false;
  return code;
}

}  // namespace
}  // namespace slipstream

using namespace slipstream;

extern "C" {

int __libc_start_main(int (*main)(int, char**, char**), int argc, char** argv, void (*init)(),
                      void (*fini)(), void (*loader_fini)(), void* stack_end) {
  program_main = main;
  return next<decltype(&__libc_start_main)>("__libc_start_main")(main_with_faults, argc, argv, init,
                                                                 fini, loader_fini, stack_end);
}

/// Drivers of graphics end where they get no memory, and wait for ever for threads that did not
/// start: from the first driver on neither fails.
void* dlopen(const char* path, int flags) noexcept {
  if (path != nullptr && std::strstr(path, "libEGL") != nullptr) is_drawing = true;
  // What they leave behind has names only as long as they stay.
  return next<decltype(&dlopen)>("dlopen")(path, flags | RTLD_NODELETE);
}

void GDALAllRegister() {
  const bool was_armed = armed.exchange(false);
  if (const auto all = next<void (*)()>("GDALAllRegister")) all();
  armed = was_armed;
}

/// What a sanitizer asks at the start of each thread.
int pthread_getattr_np(pthread_t thread, pthread_attr_t* attributes) noexcept {
  is_of_program = false;
  const int failed = next<decltype(&pthread_getattr_np)>("pthread_getattr_np")(thread, attributes);
  is_of_program = true;
  return failed;
}

// What comes next is the C library, or a sanitizer's memory, which must see who calls: it passes
// over what the loader keeps. So it is called last, and `fails` is not inlined.

void* malloc(std::size_t size) {
  static const auto allocate = next<decltype(&malloc)>("malloc");
  if (!fails(of_malloc)) return allocate(size);
  errno = ENOMEM;
  return nullptr;
}

void* calloc(std::size_t count, std::size_t size) {
  static const auto allocate = next<decltype(&calloc)>("calloc");
  if (!fails(of_malloc)) return allocate(count, size);
  errno = ENOMEM;
  return nullptr;
}

void* realloc(void* memory, std::size_t size) {
  static const auto allocate = next<decltype(&realloc)>("realloc");
  if (!fails(of_malloc)) return allocate(memory, size);
  errno = ENOMEM;
  return nullptr;
}

void* aligned_alloc(std::size_t alignment, std::size_t size) {
  static const auto allocate = next<decltype(&aligned_alloc)>("aligned_alloc");
  if (!fails(of_malloc)) return allocate(alignment, size);
  errno = ENOMEM;
  return nullptr;
}

int posix_memalign(void** memory, std::size_t alignment, std::size_t size) {
  static const auto allocate = next<decltype(&posix_memalign)>("posix_memalign");
  return fails(of_malloc) ? ENOMEM : allocate(memory, alignment, size);
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
  if (!is_file(descriptor) || !fails(of_write)) {
    const ssize_t written = ::syscall(SYS_write, descriptor, bytes, size);
    if (written > 0) note(of_write, descriptor, static_cast<std::uint64_t>(written));
    return written;
  }
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
  if (!fails(of_rename)) {
    const int result = static_cast<int>(::syscall(SYS_rename, from, to));
    if (result == 0) note(of_rename, -1);
    return result;
  }
  errno = EIO;
  return -1;
}

int fsync(int descriptor) {
  if (!fails(of_fsync)) {
    const int result = static_cast<int>(::syscall(SYS_fsync, descriptor));
    if (result == 0) note(of_fsync, descriptor);
    return result;
  }
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

// A sanitizer has operators of its own, which do not call malloc.

void* operator new(std::size_t size) {
  if (void* const memory = ::malloc(size)) return memory;
  throw std::bad_alloc();
}

void* operator new(std::size_t size, std::align_val_t alignment) {
  const auto step = static_cast<std::size_t>(alignment);
  if (void* const memory = ::aligned_alloc(step, (size + step - 1) / step * step)) return memory;
  throw std::bad_alloc();
}

void* operator new(std::size_t size, const std::nothrow_t&) noexcept {
  return ::malloc(size);
}
void* operator new[](std::size_t size) {
  return operator new(size);
}
void* operator new[](std::size_t size, std::align_val_t alignment) {
  return operator new(size, alignment);
}
void* operator new[](std::size_t size, const std::nothrow_t&) noexcept {
  return ::malloc(size);
}
