#include <algorithm>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <memory>
#include <new>
#include <optional>
#include <span>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <tbb/global_control.h>

#include "app/commands.h"
#include "app/help.h"
#include "app/process.h"
#include "app/scan_flags.h"
#include "app/whole_program.h"
#include "base/system_failure.h"
#include "io/file.h"

#ifdef SLIPSTREAM_VIEW
#include "view/opengl.h"
#endif

namespace slipstream::app {
extern const char* const program_version;  // made at build time: see version.cmake
namespace {

constexpr int failure_of_the_world = 1;
constexpr int bad_input = 2;

#ifdef SLIPSTREAM_ALL_COMMANDS
constexpr std::string_view in_whole_program = "";
#else
constexpr std::string_view in_whole_program =
    " (this program only reconstructs scans; ./dev build builds all commands)";
#endif

/// Flags that every subcommand has.
struct SharedFlags {
  bool json = false;  ///< seen by main
  int threads = 0;    ///< 0: as many as the machine has cores
};

/// Adds these and --rig to each subcommand of `app` that does work.
void add_shared_flags(CLI::App& app, const CLI::App& program, SharedFlags& shared,
                      AppliedRig& rig) {
  for (CLI::App* const command : app.get_subcommands(nullptr)) {
    add_shared_flags(*command, program, shared, rig);
    if (!command->get_subcommands(nullptr).empty()) continue;
    add_rig_flag(*command, program, rig);

    const FlagGroup group{*command};
    group.add("--json", shared.json, "print one JSON document on stdout, text on stderr");
    group.add("--threads", shared.threads, "maximum number of threads; 0: one per core");
  }
}

/// Prints the message in one line and adds it to the JSON document.
int fail(Output& output, int code, std::string_view message) noexcept {
  bool printed = false;

  try {
    std::string line(message);
    std::replace(line.begin(), line.end(), '\n', ' ');
    output.tell_failure(line);
    printed = true;
    output.document["error"] = line;
    output.finish();
  } catch (const std::exception&) {  // stdout is closed, or memory is exhausted
    if (!printed) std::fputs("slipstream: not enough memory\n", stderr);
  }
  return code;
}

const CLI::App& chosen_command(const CLI::App& program) {
  const CLI::App* command = &program;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  return *command;
}

#ifdef SLIPSTREAM_VIEW
/// The flags with which the command needs no window; empty if it has none.
std::string without_a_window(const CLI::App& command) {
  const auto has = [&](const char* flag) { return command.get_option_no_throw(flag) != nullptr; };
  if (has("--headless")) return "; without a window: --headless";
  return has("--web") ? "; without a window: --snapshot or --web" : "";
}
#endif

/// Explains why the arguments are wrong, unknown words first, with a suggestion.
std::string refusal(const CLI::App& program, const CLI::ParseError& error) {
  const CLI::App& command = chosen_command(program);
  const std::vector<std::string> words = program.remaining(true);
  const auto is_flag = [](const std::string& word) { return word.starts_with("-"); };
  const auto flag = std::find_if(words.begin(), words.end(), is_flag);

  // 1. A word that names no command.
  std::vector<std::string> known;
  for (const auto* const sub : command.get_subcommands(nullptr)) known.push_back(sub->get_name());
  if (!known.empty() && !words.empty() && !is_flag(words.front())) {
    return fmt::format("there is no command '{}'{}{}", words.front(),
                       did_you_mean(words.front(), known), in_whole_program);
  }

  // 2. A flag that the command does not have.
  if (flag == words.end()) return error.what();
  known.clear();
  for (const CLI::Option* const option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  }

  const std::string name = flag->substr(0, flag->find('='));
  return fmt::format("{} has no {}{}", command.get_name(), name, did_you_mean(name, known));
}

struct ProgramCommand {
  std::string_view name;
  AddCommand* add;
  const char* group;  ///< heading in --help
};

/// In the order of --help.
constexpr ProgramCommand program_commands[] = {
    {"demo", add_demo, "Scan"},
    {"patterns", add_patterns, "Scan"},
#ifdef SLIPSTREAM_VIEW
    {"studio", add_studio, "Scan"},
    {"project", add_project, "Scan"},
#endif
#ifdef SLIPSTREAM_ALL_COMMANDS
    {"capture", add_capture, "Scan"},
#endif
    {"reconstruct", add_reconstruct, "Scan"},
    {"check", add_check, "Scan"},
#ifdef SLIPSTREAM_ALL_COMMANDS
    {"calibrate", add_calibrate, "Calibrate"},
    {"assist", add_assist, "Calibrate"},
    {"verify", add_verify, "Calibrate"},
    {"live", add_live, "Live"},
    {"serve", add_serve, "Live"},
    {"camera", add_camera, "Live"},
    {"gpu", add_gpu, "Live"},
    {"record", add_record, "Files"},
    {"convert", add_convert, "Files"},
    {"batch", add_batch, "Files"},
#endif
#ifdef SLIPSTREAM_VIEW
    {"view", add_view, "Measure"},
#endif
    {"measure", add_measure, "Measure"},
#ifdef SLIPSTREAM_ALL_COMMANDS
    {"frame", add_frame, "Measure"},
    {"merge", add_merge, "Measure"},
    {"height", add_height, "Measure"},
    {"unwrap", add_unwrap, "Measure"},
    {"simulate", add_simulate, "Learn"},
    {"compare", add_compare, "Learn"},
    {"reproduce", add_reproduce, "Learn"},
    {"bench", add_bench, "Learn"},
#endif
    {"design", add_design, "Learn"},
};

/// The command named first; null without one, or if a rig file is read, which may hold settings of
/// any command.
const ProgramCommand* command_named(std::span<char* const> arguments) {
  const std::string_view first = arguments.size() > 1 ? arguments[1] : "";
  const auto is_rig = [](std::string_view argument) { return argument.starts_with("--rig"); };
  if (first == "serve" || std::any_of(arguments.begin(), arguments.end(), is_rig)) return nullptr;
  const auto* const found = std::ranges::find(program_commands, first, &ProgramCommand::name);
  return found == std::end(program_commands) ? nullptr : found;
}

/// Adds only the command that is named, as adding all takes milliseconds.
void add_commands(CLI::App& program, Command& chosen, std::span<char* const> arguments) {
  const ProgramCommand* const alone = command_named(arguments);

  for (const ProgramCommand& command : program_commands) {
    if (alone != nullptr && alone != &command) continue;
    command.add({program, chosen});
    program.get_subcommand(std::string(command.name))->group(command.group);
  }
}

/// In CLI11's order, the last word first. "--backwards true" becomes "--backwards=true", "help
/// live" "live --help" and "version" "--version".
std::vector<std::string> reversed(std::span<char* const> arguments) {
  std::vector<std::string> words;

  // CLI11 takes the word after a switch for an argument, so join the two.
  for (const std::string word : arguments) {
    const bool is_value = word == "true" || word == "false";
    if (is_value && !words.empty() && is_pattern_switch(words.back())) {
      words.back() += "=" + word;
    } else {
      words.push_back(word);
    }
  }

  if (!words.empty() && words.front() == "help") {
    words.erase(words.begin());
    words.push_back("--help");
  } else if (!words.empty() && words.front() == "version") {
    words.front() = "--version";
  }

  std::reverse(words.begin(), words.end());
  return words;
}

int print(const std::string& text) {
  Output words(false);
  words.say_lines(text);
  words.finish();
  return 0;
}

/// One reading of the command line and of the rig file it names. The parser's flags are bound to
/// members of this object and of its commands: it parses once, and is neither copied nor moved.
class ProgramReading {
 public:
  /// Adds the commands; does not parse yet.
  explicit ProgramReading(std::span<char* const> arguments);
  ProgramReading(const ProgramReading&) = delete;
  ProgramReading& operator=(const ProgramReading&) = delete;
  ~ProgramReading() = default;

  /// Call once. Throws CLI::ParseError, also for --help and --version with exit code 0, and Error.
  void parse() { program.parse(reversed(arguments_)); }

  CLI::App program{"3-D reconstruction by structured light", "slipstream"};
  Command chosen;
  SharedFlags shared;

 private:
  std::span<char* const> arguments_;  ///< after the program's name
};

/// An argument in quotes, as a shell takes it.
std::string quoted(std::string_view argument) {
  std::string text = "'";
  for (const char letter : argument) {
    text += letter == '\'' ? std::string(R"('\'')") : std::string(1, letter);
  }
  return text + "'";
}

/// The command as a shell takes it.
std::string command_text(std::span<char* const> arguments) {
  constexpr std::string_view plain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./,:@%";

  std::string text = "slipstream";
  for (const std::string_view argument : arguments.subspan(1)) {
    const bool is_plain =
        !argument.empty() && argument.find_first_not_of(plain) == std::string_view::npos;
    text += " " + (is_plain ? std::string(argument) : quoted(argument));
  }
  return text;
}

/// For Command::read_again.
std::shared_ptr<const Command> read_again(std::span<char* const> arguments) {
  const auto reading = std::make_shared<ProgramReading>(arguments);
  reading->parse();
  locating(reading->chosen.rig, [&] { require_distinct_files(chosen_command(reading->program)); });

  return {reading, &reading->chosen};
}

ProgramReading::ProgramReading(std::span<char* const> arguments)
    : arguments_(arguments.subspan(1)) {
  program.formatter(help_layout());
  program.require_subcommand(1);
  program.get_help_ptr()->description("print the common options");
  program.set_help_all_flag("--help-all", "print all options");
  program.set_version_flag("-V,--version", program_version)->description("print the version");

  chosen.read_again = [arguments] { return read_again(arguments); };
  add_commands(program, chosen, arguments);
  add_shared_flags(program, program, shared, chosen.rig);
}

int run_program(std::span<char* const> arguments, Output& output) {
  if (arguments.size() < 2) return print(greeting());

  // 1. The program, its commands and their flags.
  ProgramReading reading(arguments);
  const CLI::App& program = reading.program;
  try {
    reading.parse();
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() != 0) {
      return fail(output, bad_input, refusal(program, error) + "; see --help");
    }
    std::ostringstream text;
    reading.program.exit(error, text, text);
    std::string words = text.str();
    words.erase(words.find_last_not_of('\n') + 1);
    return print(words);
  }

  // 2. Run the command.
  return locating(reading.chosen.rig, [&] {
    const int threads = reading.shared.threads;
    require_distinct_files(chosen_command(program));
    require_in_range(threads >= 0, "--threads", threads, "0 (all cores) or more");

    std::optional<tbb::global_control> limit;
    if (threads > 0) {
      limit.emplace(tbb::global_control::max_allowed_parallelism,
                    static_cast<std::size_t>(threads));
    }

#ifdef SLIPSTREAM_VIEW
    try {
      reading.chosen.work(output);
    } catch (const opengl::NoDesktop& error) {
      throw WorldError(error.what() + without_a_window(chosen_command(program)));
    }
    if (opengl::desktop_is_gone()) output.warn("the desktop has ended, and with it the window");
#else
    reading.chosen.work(output);
#endif
    output.finish();
    return output.exit_code;
  });
}

}  // namespace

}  // namespace slipstream::app

int main(int argc, char** argv) {
  using namespace slipstream;
  const std::span<char* const> arguments(argv, static_cast<std::size_t>(argc));
  std::string failure;  // of the program with all commands
#ifdef SLIPSTREAM_WHOLE_PROGRAM
  const std::string_view first = argc > 1 ? argv[1] : "";
  const bool asks_version = first == "--version" || first == "-V" || first == "version";
  if (!asks_version && app::command_named(arguments) == nullptr) {
    failure = app::run_whole_program(argv);
  }
#endif

  // First, so that SIGHUP never ends a service.
  if (argc > 1 && std::string_view(argv[1]) == "serve") app::reload_at_hangup();
  app::prepare_process();

  const auto has_argument = [&](std::string_view word) {
    return std::find(argv, argv + argc, word) != argv + argc;
  };
  const bool json = has_argument("--json");
  const bool piped =
      has_argument(standard_output) || has_argument("-o-") || has_argument("--output=-");
  app::Output output(json, piped);  // also if flags cannot be parsed
  output.run = {app::program_version, app::command_text(arguments)};

  try {
    if (!failure.empty()) throw WorldError(failure);
    throw_if(json && piped, "--json and '-' both write to standard output; give a file");
    return app::run_program(arguments, output);
  } catch (const Error& error) {
    return app::fail(output, app::bad_input, error.what());
  } catch (const std::filesystem::filesystem_error& error) {  // e.g. name too long, circular links
    const bool of_system = is_system_failure(error.code().value());
    return app::fail(output, of_system ? app::failure_of_the_world : app::bad_input,
                     error.path1().string() + ": " + error.code().message());
  } catch (const std::bad_alloc&) {
    return app::fail(output, app::failure_of_the_world, "not enough memory");
  } catch (const std::exception& error) {
    return app::fail(output, app::failure_of_the_world, error.what());
  }
}
