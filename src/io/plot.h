#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "slipstream/cloud.h"
#include "slipstream/image.h"

namespace slipstream {

/// A line through points, interrupted at values that are not finite.
struct PlotLine {
  std::string label;  ///< in the legend; empty: none shown
  std::vector<double> x{};
  std::vector<double> y{};

  void add(double at_x, double at_y) {
    x.push_back(at_x);
    y.push_back(at_y);
  }
};

enum class PlotScale { linear, logarithmic };

/// Lines over common axes.
struct LinePlot {
  std::string title, x_label, y_label;
  PlotScale y_scale = PlotScale::linear;
  std::vector<PlotLine> lines;
};

/// One bar for each bin of equal width from `low` to `high`.
struct BarPlot {
  std::string title, x_label, y_label;
  double low = 0, high = 1;
  std::vector<double> heights;
};

/// Draws a plot as a PNG. Throws Error for another ending or a plot without finite values,
/// WorldError if it cannot be written.
void write_plot(const std::filesystem::path& path, const LinePlot& plot);
void write_plot(const std::filesystem::path& path, const BarPlot& plot);

/// The range of values of a preview's colours.
struct ValueRange {
  double low = 0;
  double high = 1;
};

/// Slightly more than the 1st to 99th percentile of the finite values, so that a few outliers do
/// not take up all colours. [0, 1] without finite values.
ValueRange robust_range(const Image<double>& map);

/// A PNG with depth in colours, shaded by the surface's slope, and a scale in millimetres: the part
/// of the picture that has points, with colours for an object rather than for a wall behind it.
/// Pixels without a point are dark grey. Sides longer than 1000 pixels are reduced.
void write_depth_preview(const std::filesystem::path& path, const Cloud& cloud);
/// The same as the bytes of a PNG file.
std::vector<std::uint8_t> depth_preview(const Cloud& cloud);

/// The same for a map, unshaded, with `unit` printed above the scale; enlarges small maps.
void write_map_preview(const std::filesystem::path& path, const Image<double>& map,
                       const std::string& unit);

/// Modulation, grey levels, and wrapped phase, rad, side by side, each as write_map_preview draws
/// it.
void write_modulation_and_phase(const std::filesystem::path& path, const Image<double>& modulation,
                                const Image<double>& phase);

/// The range of an axis, with round numbers for its marks.
struct PlotAxis {
  double low = 0;
  double high = 1;
  std::vector<double> marks;
};

/// Linear axis for values from `low` to `high`, which may be equal, with about `count` marks at
/// multiples of 1, 2 or 5 times a power of ten.
PlotAxis round_axis(double low, double high, int count);

/// The marks of round_axis within `low` to `high`, for a scale that ends at its values.
std::vector<double> marks_between(double low, double high, int count);

/// Logarithmic axis, in powers of ten, for positive values from `low` to `high`: marks at whole
/// powers, at most `count`.
PlotAxis decade_axis(double low, double high, int count);

}  // namespace slipstream
