#include <algorithm>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <exception>
#include <fstream>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "app/commands.h"
#include "app/live.h"
#include "app/stop_signal.h"
#include "slipstream/base/error.h"
#include "slipstream/io/saved_scan.h"

namespace slipstream::app {
namespace {

std::vector<std::string> own_arguments() {
  std::ifstream file("/proc/self/cmdline");
  std::vector<std::string> words;
  for (std::string word; std::getline(file, word, '\0');) words.push_back(word);
  return words;
}

/// What can be served of that.
LiveFlags served(LiveFlags flags) {
  flags.headless = true;
  if (flags.publish.empty() && flags.record.empty()) {
    throw Error(
        "the rig file says neither publish nor record, so no cloud would go anywhere; say where, "
        "as "
        "publish: [web:8080]");
  }
  require_good(flags);
  return flags;
}

/// Each run, also of a service that was started again, writes files of its own.
LiveFlags with_free_names(LiveFlags flags, Output& output) {
  const auto choose = [&](std::string& name, std::size_t begin = 0) {
    if (name.size() <= begin) return;
    const std::string path = name.substr(begin), free = free_path(path).string();
    if (free != path) output.say("{} is there already; {} is written", path, free);
    name.replace(begin, path.size(), free);
  };
  for (std::string* name : {&flags.output, &flags.model, &flags.record}) choose(*name);
  for (std::string& sink : flags.publish) {
    if (constexpr std::string_view file = "mcap:"; sink.starts_with(file)) {
      choose(sink, file.size());
    }
  }
  return flags;
}

void serve(const LiveFlags& given, Output& output) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);  // a log is read while it is written
  const auto again = given.again;
  const RigSaid& rig = *given.rig;
  LiveFlags now = served(given);
  const auto refuse = [&](const std::exception& error) {
    output.warn(fmt::format("{}; it goes on as before", located(rig, error.what())));
  };
  std::optional<LiveFlags> before;  // until a run by a new file has begun
  while (true) {
    std::optional<LiveFlags> next;
    now.begun = [&] { before.reset(); };
    now.hung_up = [&] {
      try {
        next = served(again());
        output.say("starting anew");
      } catch (const std::exception& error) {
        refuse(error);
      }
      return next.has_value();
    };
    try {
      live(with_free_names(now, output), output);
      if (!next) return;
      before = std::exchange(now, *next);
    } catch (const std::exception& error) {  // of what shows only when all is opened
      if (!before) throw;
      refuse(error);
      now = *std::exchange(before, std::nullopt);
    }
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

void add_serve(CLI::App& program, Command& chosen, const RigSaid& rig) {
  const auto [command, flags] =
      add_command(program, chosen, serve, "serve",
                  "live without a window, as one file says, until SIGTERM; SIGHUP reads it again");
  add_live_flags(command, flags);
  flags.rig = &rig;
  flags.again = [&program, &read = flags, none = flags] {
    std::vector<std::string> words = own_arguments();
    std::reverse(words.begin(), words.end());
    words.pop_back();
    read = none;
    program.parse(words);
    return read;
  };
  command.app.footer("Example:\n  slipstream serve rig.yaml");
}

}  // namespace slipstream::app
