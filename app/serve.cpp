#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "app/commands.h"
#include "app/live.h"
#include "app/stop_signal.h"
#include "slipstream/error/error.h"

namespace slipstream::app {
namespace {

/// With the same arguments, in the same process, which whoever watches it knows.
void start_anew() {
  std::ifstream file("/proc/self/cmdline");
  std::string words{std::istreambuf_iterator<char>(file), {}};
  std::vector<char*> arguments;
  for (std::size_t at = 0; at < words.size(); at = words.find('\0', at) + 1) {
    arguments.push_back(words.data() + at);
  }
  arguments.push_back(nullptr);
  if (arguments.front() != nullptr) ::execvp(arguments.front(), arguments.data());
  throw WorldError("cannot start anew");
}

void serve(const LiveFlags& given, Output& output) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // a log is read while it is written
  LiveFlags flags = given;
  flags.headless = true;
  if (flags.publish.empty() && flags.record.empty()) {
    throw Error(
        "the rig file says neither publish nor record, so no cloud would go anywhere; say where, "
        "as "
        "publish: [web:8080]");
  }
  live(flags, output);
  if (hung_up()) {
    output.say("starting anew");
    start_anew();
  }
}

}  // namespace

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

void add_serve(CLI::App& program, Command& chosen) {
  const auto [command, flags] =
      add_command(program, chosen, serve, "serve",
                  "live without a window, as one file says, until SIGTERM; SIGHUP reads it again");
  add_live_flags(command, flags);
  command.app.footer("Example:\n  slipstream serve rig.yaml");
}

}  // namespace slipstream::app
