#pragma once

#include <filesystem>

#include "slipstream/io/plot.h"

namespace slipstream {

/// Draws a plot as a PNG for people. Throws Error for another ending or a plot with no finite
/// value, WorldError when it cannot be written.
void write_plot(const std::filesystem::path& path, const Plot& plot);

}  // namespace slipstream
