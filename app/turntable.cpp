#include "app/turntable.h"

#include <cmath>
#include <cstdlib>
#include <iostream>
#include <string_view>

#include <sys/wait.h>

namespace slipstream::app {
namespace {

/// The command with a number instead of each `name`.
std::string with_number(std::string command, std::string_view name, const std::string& number) {
  for (std::size_t at = command.find(name); at != command.npos; at = command.find(name, at)) {
    command.replace(at, name.size(), number);
  }
  return command;
}

/// Runs the command with its output on stderr. Throws WorldError unless it succeeds.
void run_command(const std::string& command) {
  // The line break ends a comment at the command's end.
  const int status = std::system(("{ " + command + "\n} 1>&2").c_str());
  if (status == 0) return;

  std::string why = "cannot be run";
  if (status != -1 && WIFEXITED(status)) {
    why = fmt::format("failed with exit code {}", WEXITSTATUS(status));
  } else if (status != -1) {
    why = fmt::format("was ended by signal {}", WTERMSIG(status));
  }
  throw WorldError(fmt::format("--turn-command '{}' {}", command, why));
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

std::string folder_of_view(const TurntableFlags& flags, const fs::path& folder, int number) {
  const int views = flags.views.value_or(0);
  const int digits = views < 100 ? 2 : views < 1000 ? 3 : 4;
  return (folder / fmt::format("view{:0{}}", number, digits)).string();
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
  run_command(command);
}

void tell_views(const TurntableFlags& flags, const fs::path& folder, Output& output) {
  output.say("{} views, {:g} degrees apart, in {}", *flags.views, turn_step(flags),
             folder.string());
  output.say("join them: slipstream merge {} --turntable", (folder / "view*").string());

  for (int view = 1; view <= *flags.views; ++view) {
    output.list("views").push_back(folder_of_view(flags, folder, view));
  }
  output.document["folder"] = folder.string();
  output.document["step_degrees"] = turn_step(flags);
}

}  // namespace slipstream::app
