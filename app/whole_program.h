#pragma once

#include <filesystem>
#include <string>

namespace slipstream::app {

/// The mark of a program of slipstream, which names its version; empty for all other files.
std::string mark_of(const std::filesystem::path& program);

/// Replaces this program by the one with all commands: whole/slipstream in this program's folder,
/// as built, or ../libexec/slipstream/slipstream, as installed. A program of another mark is not
/// run. Returns why it cannot, in one line.
std::string run_whole_program(char* const* arguments);

}  // namespace slipstream::app
