#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "tools/reproduce/reproduction.h"

namespace slipstream {

/// One that has been run, with the files of its plots.
struct Reproduced {
  Reproducible item;
  Reproduction result;
  std::vector<std::filesystem::path> plots{};
};

/// What a terminal shows of it: its name, a line for each cell, note and plot.
std::string text_of(const Reproduced& reproduced);

/// Its section of a Markdown report that stands in `folder`; pictures relative to that.
std::string markdown_of(const Reproduced& reproduced, const std::filesystem::path& folder);

}  // namespace slipstream
