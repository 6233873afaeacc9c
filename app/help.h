#pragma once

#include <memory>
#include <string>

#include <CLI/App.hpp>

namespace slipstream::app {

/// Lays out --help, wrapped to the terminal's width.
std::shared_ptr<CLI::FormatterBase> help_layout();

/// The text printed without arguments: commands to begin with.
std::string greeting();

}  // namespace slipstream::app
