#include "app/turntable.h"

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string_view>

namespace slipstream::app {
namespace {

/// The command with a number instead of each `name`.
std::string with_number(std::string command, std::string_view name, const std::string& number) {
  for (std::size_t at = command.find(name); at != command.npos; at = command.find(name, at)) {
    command.replace(at, name.size(), number);
  }
  return command;
}

}  // namespace

void add_turntable_flags(const FlagGroup& group, TurntableFlags& flags) {
  group.add("--turntable", flags.views,
            "this many views of an object that turns between them, into view01, view02 and so on");
  group.add("--turn-step", flags.step,
            "with --turntable: degrees from view to view; default: a full turn over all views");
}

double turn_step(const TurntableFlags& flags) {
  constexpr int most = 1000;
  const int views = flags.views.value_or(0);
  require_in_range(views >= 2 && views <= most, "--turntable", views, "2 to 1000");

  const double step = flags.step.value_or(360.0 / views);
  require_in_range(std::isfinite(step) && step != 0 && std::abs(step) <= 180, "--turn-step", step,
                   "-180 to 180 degrees, not 0");
  return step;
}

std::string folder_of_view(const fs::path& folder, int number) {
  return (folder / fmt::format("view{:02}", number)).string();
}

void turn_table(const TurntableFlags& flags, int number, Output& output) {
  const double step = turn_step(flags);
  if (flags.command.empty()) {
    output.say("turn the object by {:g} degrees for view {} of {}, then press Enter", step, number,
               *flags.views);
    std::string line;
    if (!std::getline(std::cin, line)) {
      throw WorldError(
          "no key was pressed: standard input has ended; --turn-command runs a command "
          "instead");
    }
    return;
  }

  const std::string command =
      with_number(with_number(flags.command, "{step}", fmt::format("{:g}", step)), "{view}",
                  std::to_string(number));
  const int status = std::system(command.c_str());
  if (status != 0) {
    throw WorldError(fmt::format("--turn-command '{}' failed with status {}", command, status));
  }
}

void tell_views(const TurntableFlags& flags, const fs::path& folder, Output& output) {
  output.say("{} views, {:g} degrees apart, in {}", *flags.views, turn_step(flags),
             folder.string());
  for (int view = 1; view <= *flags.views; ++view) {
    output.list("views").push_back(folder_of_view(folder, view));
  }
  output.document["folder"] = folder.string();
  output.document["step_degrees"] = turn_step(flags);
}

}  // namespace slipstream::app
