#include "base/system_failure.h"

#include <cerrno>
#include <cstring>
#include <vector>

#include <fmt/format.h>

#include "slipstream/error.h"

#ifdef __unix__
#include <fcntl.h>
#include <unistd.h>
#endif

namespace slipstream {

bool is_system_failure(int error_number) {
  return error_number == EMFILE || error_number == ENFILE || error_number == ENOMEM ||
         error_number == EINTR || error_number == EIO;
}

#ifdef __unix__

void require_descriptors(std::size_t count, std::string_view what) {
  // Opens as many for a moment: neither the process's limit nor the system's may be reached.
  std::vector<int> opened;
  opened.reserve(count);  // without memory all are closed
  int reason = 0;
  while (opened.size() < count && reason == 0) {
    const int descriptor = ::open("/dev/null", O_RDONLY | O_CLOEXEC);
    if (descriptor < 0) {
      reason = errno;
    } else {
      opened.push_back(descriptor);
    }
  }

  for (const int descriptor : opened) ::close(descriptor);
  if (reason == 0) return;

  throw WorldError(
      fmt::format("{}: needs {} file descriptors, but only {} are left: {}; raise the "
                  "limit, e.g. by ulimit -n 1024",
                  what, count, opened.size(), std::strerror(reason)));
}

#else

void require_descriptors(std::size_t /*count*/, std::string_view /*what*/) {}

#endif

}  // namespace slipstream
