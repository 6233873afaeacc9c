#pragma once

#include <cstdint>
#include <filesystem>
#include <vector>

#include "slipstream/plot/plot.h"

namespace slipstream {

/// The bytes of a PNG of lines. Throws Error for a plot with no finite value.
std::vector<std::uint8_t> plot_png(const LinePlot& plot);

/// Draws a plot as a PNG for people. Throws Error for another ending or a plot with no finite
/// value, WorldError when it cannot be written.
void write_plot(const std::filesystem::path& path, const Plot& plot);

}  // namespace slipstream
