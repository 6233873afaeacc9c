#include <cstdio>
#include <exception>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include <fmt/format.h>

#include "app/commands.h"
#include "app/live.h"
#include "app/process.h"
#include "slipstream/base/error.h"
#include "slipstream/io/saved_scan.h"

namespace slipstream::app {
namespace {

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

void add_serve(CLI::App& program, Command& chosen) {
  const auto [command, flags] =
      add_command(program, chosen, serve, "serve",
                  "live without a window, as one file says, until SIGTERM; SIGHUP reads it again");
  add_live_flags(command, flags);
  flags.rig = &chosen.rig;
  flags.again = [&program, &rig = chosen.rig, &read = flags, none = flags] {
    read = none;
    program.parse(std::vector<std::string>(rig.arguments));
    return read;
  };
  command.app.footer("Example:\n  slipstream serve rig.yaml");
}

}  // namespace slipstream::app
