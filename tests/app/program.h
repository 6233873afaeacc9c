#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace slipstream {

/// What a run of the program left.
struct ProgramRun {
  int exit_code = -1;
  std::string out;
  std::string err;
};

/// Runs the program with those arguments, stdin empty. `largest_file`: bytes that any file of it
/// may grow to, as on a full disk; none where negative.
ProgramRun run_program(const std::vector<std::string>& arguments, long largest_file = -1);

}  // namespace slipstream
