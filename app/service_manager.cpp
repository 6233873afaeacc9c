#include "app/service_manager.h"

#include <algorithm>
#include <cstddef>
#include <cstdlib>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

namespace slipstream::app {

void tell_service_manager(const std::string& state) {
  const char* const named = std::getenv("NOTIFY_SOCKET");
  sockaddr_un address{};
  const std::string path = named == nullptr ? "" : named;
  if (path.size() < 2 || path.size() > sizeof address.sun_path) return;
  address.sun_family = AF_UNIX;
  std::copy(path.begin(), path.end(), address.sun_path);
  if (path.front() == '@') address.sun_path[0] = '\0';  // a name that is no file's
  const int descriptor = ::socket(AF_UNIX, SOCK_DGRAM, 0);
  if (descriptor < 0) return;
  const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + path.size());
  // The manager's is the only ear; where it does not listen there is nobody to tell.
  static_cast<void>(::sendto(descriptor, state.data(), state.size(), 0,
                             reinterpret_cast<const sockaddr*>(&address), length));
  ::close(descriptor);
}

}  // namespace slipstream::app
