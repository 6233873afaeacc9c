#include <exception>
#include <new>
#include <optional>
#include <string>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <tbb/global_control.h>

#include "app/commands.h"
#include "slipstream/error/error.h"

namespace slipstream::app {
namespace {

constexpr int failure_of_the_world = 1;
constexpr int bad_input = 2;

/// Flags that every subcommand has.
struct SharedFlags {
  bool json = false;
  int threads = 0;  ///< 0: as many as the machine has cores
};

/// Adds them to each subcommand that does work.
void add_shared_flags(CLI::App& program, SharedFlags& shared) {
  for (CLI::App* const command : program.get_subcommands(nullptr)) {
    add_shared_flags(*command, shared);
    if (!command->get_subcommands(nullptr).empty()) continue;
    const FlagGroup group{*command};
    group.add("--json", shared.json, "one JSON document on stdout, words to stderr");
    group.add("--threads", shared.threads, "at most so many; 0: one for each core");
  }
}

int fail(int code, std::string message) {
  for (char& c : message) {
    if (c == '\n') c = ' ';
  }
  fmt::print(stderr, "slipstream: {}\n", message);
  return code;
}

/// Returns the exit code.
int run(const Command& command, const SharedFlags& shared) {
  if (shared.threads < 0) {
    throw Error(fmt::format("--threads {} is out of range; 0 (all cores) or more", shared.threads));
  }
  std::optional<tbb::global_control> limit;
  if (shared.threads > 0) {
    limit.emplace(tbb::global_control::max_allowed_parallelism,
                  static_cast<std::size_t>(shared.threads));
  }
  Output output(shared.json);
  command(output);
  output.finish();
  return output.exit_code;
}

int run_program(int argc, char** argv) {
  CLI::App program("slipstream: 3-D reconstruction by structured light", "slipstream");
  program.require_subcommand(1);
  program.set_version_flag("--version", SLIPSTREAM_VERSION);
  Command chosen;
  add_patterns(program, chosen);
  add_simulate(program, chosen);
  add_calibrate(program, chosen);
  add_design(program, chosen);
  add_reconstruct(program, chosen);
  add_check(program, chosen);
  add_live(program, chosen);
#ifdef SLIPSTREAM_VIEW
  add_project(program, chosen);
  add_view(program, chosen);
#endif
  add_record(program, chosen);
  add_camera(program, chosen);
  add_reproduce(program, chosen);
  add_bench(program, chosen);
  SharedFlags shared;
  add_shared_flags(program, shared);

  try {
    program.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return program.exit(error);
    return fail(bad_input, fmt::format("{}; see --help", error.what()));
  }
  return run(chosen, shared);
}

}  // namespace

}  // namespace slipstream::app

int main(int argc, char** argv) {
  using namespace slipstream;
  try {
    return app::run_program(argc, argv);
  } catch (const Error& error) {
    return app::fail(app::bad_input, error.what());
  } catch (const std::bad_alloc&) {
    return app::fail(app::failure_of_the_world, "not enough memory");
  } catch (const std::exception& error) {
    return app::fail(app::failure_of_the_world, error.what());
  }
}
