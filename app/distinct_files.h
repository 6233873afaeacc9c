#pragma once

#include <CLI/App.hpp>

namespace slipstream::app {

/// Throws Error where an output of the command is an input of it, or two outputs are one file.
void require_distinct_files(const CLI::App& command);

}  // namespace slipstream::app
