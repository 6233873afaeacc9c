#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

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

void add_serve(CLI::App& program, Command& chosen) {
  const auto [command, flags] =
      add_command(program, chosen, serve, "serve",
                  "live without a window, as one file says, until SIGTERM; SIGHUP reads it again");
  add_live_flags(command, flags);
  command.app.footer("Example:\n  slipstream serve rig.yaml");
}

}  // namespace slipstream::app
