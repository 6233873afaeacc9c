#include "io/plot.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numbers>
#include <string>

#include "base/object_range.h"
#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "io/canvas.h"
#include "io/compressed_pictures.h"
#include "io/file.h"
#include "io/pictures.h"
#include "slipstream/image.h"
#include "slipstream/surface.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

constexpr Colour paper{255, 255, 255};
constexpr Colour ink{60, 60, 60};
constexpr Colour grid{228, 228, 228};
/// Blue, red, green, violet, orange, cyan: distinguishable for most readers.
constexpr std::array<Colour, 6> line_colours{
    {{30, 110, 180}, {200, 50, 50}, {40, 140, 60}, {130, 70, 170}, {230, 130, 0}, {30, 160, 170}}};

constexpr int width = 800, height = 520;
constexpr int legend_line = 18;  // below the axes, where it hides no curve

constexpr int left = 100, right = width - 30, top = 50, bottom = height - 70;

std::string text_of_mark(double mark) {
  return fmt::format("{:.6g}", std::abs(mark) < 1e-12 ? 0 : mark);
}

/// A page with axes and labels; converts values to positions.
class Axes {
 public:
  template <class AnyPlot>
  Axes(const AnyPlot& plot, PlotAxis x, PlotAxis y, PlotScale y_scale, int legend_lines = 0)
      : x_(std::move(x)),
        y_(std::move(y)),
        y_scale_(y_scale),
        page_({width, height + legend_lines * legend_line}, paper) {
    // 1. Grid lines with their values.
    for (const double mark : x_.marks) {
      const double at = x_place(mark);
      draw_line(page_, {at, top}, {at, bottom}, 1, grid);
      const std::string text = text_of_mark(mark);
      draw_text(page_, text, {at - text_width(text) / 2, bottom + 20}, ink);
    }

    for (const double mark : y_.marks) {
      const double at = y_mark_place(mark);
      draw_line(page_, {left, at}, {right, at}, 1, grid);
      const std::string text =
          y_scale == PlotScale::logarithmic ? fmt::format("1e{:.0f}", mark) : text_of_mark(mark);
      draw_text(page_, text, {left - 8 - text_width(text), at + 4}, ink);
    }

    // 2. The frame around the curves.
    const std::array<CanvasPoint, 5> frame{
        {{left, top}, {right, top}, {right, bottom}, {left, bottom}, {left, top}}};
    for (std::size_t i = 1; i < frame.size(); ++i) draw_line(page_, frame[i - 1], frame[i], 1, ink);

    // 3. The title, the y label above its axis, and the x label centred below.
    draw_text(page_, plot.title, {left, 22}, ink);
    draw_text(page_, plot.y_label, {8, top - 10}, ink);
    const double middle = (left + right - text_width(plot.x_label)) / 2;
    draw_text(page_, plot.x_label, {middle, height - 18}, ink);
  }

  [[nodiscard]] CanvasPoint place(double x, double y) const {
    return {x_place(x), y_mark_place(y_scale_ == PlotScale::logarithmic ? std::log10(y) : y)};
  }

  [[nodiscard]] bool shows(double x, double y) const {
    return std::isfinite(x) && std::isfinite(y) && (y_scale_ == PlotScale::linear || y > 0);
  }

  void explain(int line, const std::string& label, Colour colour) {
    const double at = height + line * legend_line;
    draw_line(page_, {left, at - 4}, {left + 25, at - 4}, 2, colour);
    draw_text(page_, label, {left + 32, at}, ink);
  }

  /// From 0 to `height`.
  void draw_bar(double from, double to, double height) {
    const CanvasPoint end = place(from, height), zero = place(to, 0);

    // The bar hangs from zero if its value is negative.
    const double upper = std::min(end.y, zero.y);
    const Size size{static_cast<int>(zero.x - end.x),
                    static_cast<int>(std::abs(zero.y - end.y)) + 1};

    fill(page_, {static_cast<int>(end.x), static_cast<int>(upper), size}, line_colours[0]);
  }

  [[nodiscard]] Canvas& picture() { return page_; }

 private:
  [[nodiscard]] double x_place(double x) const {
    return left + std::round((x - x_.low) / (x_.high - x_.low) * (right - left));
  }

  [[nodiscard]] double y_mark_place(double y) const {
    const double share = std::clamp((y - y_.low) / (y_.high - y_.low), -0.01, 1.01);
    // Values far outside would otherwise draw lines across the title.
    return bottom - std::round(share * (bottom - top));
  }

  PlotAxis x_, y_;
  PlotScale y_scale_;
  Canvas page_;
};

struct Extent {
  double low = std::numeric_limits<double>::infinity();
  double high = -std::numeric_limits<double>::infinity();

  void include(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

void require_some(const Extent& extent, const std::string& title) {
  throw_if(!(extent.low <= extent.high), "plot '{}' has no finite value to show", title);
}

Canvas drawn(const LinePlot& plot) {
  // 1. The range of all values that can be shown.
  const bool logarithmic = plot.y_scale == PlotScale::logarithmic;
  Extent x, y;

  for (const PlotLine& line : plot.lines) {
    for (std::size_t i = 0; i < line.x.size(); ++i) {
      if (!std::isfinite(line.x[i]) || !std::isfinite(line.y[i])) continue;
      x.include(line.x[i]);
      if (!logarithmic || line.y[i] > 0) y.include(line.y[i]);
    }
  }

  require_some(x, plot.title);
  require_some(y, plot.title);

  // 2. The axes, with room for the legend.
  const auto labelled =
      std::ranges::count_if(plot.lines, [](const PlotLine& line) { return !line.label.empty(); });

  Axes page(plot, round_axis(x.low, x.high, 8),
            logarithmic ? decade_axis(y.low, y.high, 10) : round_axis(y.low, y.high, 8),
            plot.y_scale, static_cast<int>(labelled));

  // 3. The lines, broken where a value cannot be shown.
  int explained = 0;
  for (std::size_t k = 0; k < plot.lines.size(); ++k) {
    const PlotLine& line = plot.lines[k];
    const Colour colour = line_colours[k % line_colours.size()];

    for (std::size_t i = 0; i < line.x.size(); ++i) {
      if (!page.shows(line.x[i], line.y[i])) continue;
      const CanvasPoint here = page.place(line.x[i], line.y[i]);
      // Few points are also marked one by one.
      if (line.x.size() <= 40) draw_line(page.picture(), here, here, 6, colour);

      if (i == 0 || !page.shows(line.x[i - 1], line.y[i - 1])) continue;
      draw_line(page.picture(), page.place(line.x[i - 1], line.y[i - 1]), here, 1, colour);
    }

    if (!line.label.empty()) page.explain(explained++, line.label, colour);
  }

  return page.picture();
}

Canvas drawn(const BarPlot& plot) {
  // The bars begin at 0, so the axis contains it.
  Extent y;
  y.include(0);
  for (const double bar : plot.heights) {
    if (std::isfinite(bar)) y.include(bar);
  }

  if (plot.heights.empty()) require_some({}, plot.title);
  Axes page(plot, round_axis(plot.low, plot.high, 8), round_axis(y.low, y.high, 8),
            PlotScale::linear);

  const double step = (plot.high - plot.low) / static_cast<double>(plot.heights.size());
  for (std::size_t i = 0; i < plot.heights.size(); ++i) {
    if (!std::isfinite(plot.heights[i])) continue;
    const double from = plot.low + step * static_cast<double>(i);
    page.draw_bar(from, from + step, plot.heights[i]);
  }

  return page.picture();
}

constexpr Colour background{40, 42, 46};
constexpr Colour page_ink{225, 225, 225};
constexpr int smallest_height = 240;  // of a page

/// Converts values to colours, each to a square of `side` pixels; non-finite ones get the
/// background.
Canvas coloured(const Image<double>& map, const ValueRange& range, const ColourMap& colours,
                int side = 1) {
  Canvas picture({map.width() * side, map.height() * side}, background);

  for_each_pixel_in_order(map.size(), [&](int column, int row) {
    const double value = map(column, row);
    if (!std::isfinite(value)) return;

    const double level = 255 * (value - range.low) / (range.high - range.low);
    const auto index = static_cast<std::size_t>(std::clamp(level, 0.0, 255.0) + 0.5);
    fill(picture, {column * side, row * side, {side, side}}, colours[index]);
  });
  return picture;
}

/// A range slightly wider than the values; at least a thousandth of them, for a map that is the
/// same everywhere.
ValueRange with_margin(double low, double high) {
  const double margin = std::max(0.02 * (high - low), 1e-3 * std::abs(high) + 1e-9);
  return {low - margin, high + margin};
}

/// The smallest rectangle with all finite values; the whole map without any.
Rectangle measured_part(const Image<double>& map) {
  int left = map.width(), top = map.height(), right = -1, bottom = -1;
  for_each_pixel_in_order(map.size(), [&](int column, int row) {
    if (!std::isfinite(map(column, row))) return;
    left = std::min(left, column), right = std::max(right, column);
    top = std::min(top, row), bottom = row;
  });

  if (right < 0) return {0, 0, map.size()};
  return {left, top, {right - left + 1, bottom - top + 1}};
}

Canvas part_of(const Canvas& picture, const Rectangle& area) {
  Canvas part(area.size);
  for (int row = 0; row < area.size.height; ++row) {
    std::copy_n(picture.row(area.y + row) + area.x, area.size.width, part.row(row));
  }
  return part;
}

void copy(const Canvas& picture, Canvas& page, int left, int top) {
  for (int row = 0; row < picture.height(); ++row) {
    std::copy_n(picture.row(row), picture.width(), page.row(top + row) + left);
  }
}

/// The picture with a colour bar at its right, labelled at round values.
Canvas with_scale(const Canvas& picture, const ValueRange& range, const std::string& unit,
                  const ColourMap& colours) {
  constexpr int bar_width = 22, margin = 16, label_width = 92;
  const int height = std::max(picture.height(), smallest_height);
  Canvas page({picture.width() + margin + bar_width + label_width, height}, background);
  copy(picture, page, 0, 0);

  // The bar: a ramp of all values in the range, the largest at the bottom.
  const int left = picture.width() + margin, top = 40, bottom = height - 20;
  Image<double> ramp({bar_width, bottom - top});
  const auto value_at = [&](int y) {
    return range.low + (range.high - range.low) * y / (bottom - top - 1);
  };

  for (int y = 0; y < ramp.height(); ++y) std::fill_n(ramp.row(y), bar_width, value_at(y));

  copy(coloured(ramp, range, colours), page, left, top);
  draw_text(page, unit, {left + 0.0, top - 14.0}, page_ink);

  for (const double mark : marks_between(range.low, range.high, 8)) {
    const double share = (mark - range.low) / (range.high - range.low);
    const int y = top + static_cast<int>(std::lround(share * (bottom - top - 1)));
    const int right = left + bar_width;
    fill(page, {right, y, {6, 1}}, page_ink);
    draw_text(page, fmt::format("{:g}", mark), {right + 9.0, y + 4.0}, page_ink);
  }

  return page;
}

std::vector<std::uint8_t> png_of(const Canvas& picture) {
  static_assert(sizeof(Colour) == 3);
  const auto* const samples = reinterpret_cast<const std::uint8_t*>(picture.begin());
  return png_file_of(PictureView(ImageView(samples, {3 * picture.width(), picture.height()}), 3));
}

Canvas preview(const Canvas& picture, const ValueRange& range, const std::string& unit,
               const ColourMap& colours) {
  constexpr double longest_side = 1000;
  const double times = std::max(picture.width(), picture.height()) / longest_side;

  return with_scale(times > 1 ? reduced(picture, times) : picture, range, unit, colours);
}

Canvas preview_of_map(const Image<double>& map, const ValueRange& range, const std::string& unit) {
  ColourMap colours = depth_colours();
  std::reverse(colours.begin(), colours.end());  // large values stand out, like near depths

  // A map of a few pixels is enlarged, each pixel to a square.
  const int side = std::max(1, smallest_height / std::max({map.width(), map.height(), 1}));

  return preview(coloured(map, range, colours, side), range, unit, colours);
}

}  // namespace

PlotAxis round_axis(double low, double high, int count) {
  // A range around equal values.
  if (!(high > low)) {
    const double margin = low == 0 ? 1 : 0.1 * std::abs(low);
    low -= margin;
    high = low + 2 * margin;
  }

  // The step is the smallest of 1, 2, 5 and 10 times a power of ten that gives at most `count`
  // steps from `low` to `high`. Here and below, 1e-9 absorbs rounding errors.
  const double raw = (high - low) / count;
  const double power = std::pow(10, std::floor(std::log10(raw)));

  double step = 10 * power;
  for (const double factor : {5.0, 2.0, 1.0}) {
    if (raw <= factor * power * (1 + 1e-9)) step = factor * power;
  }

  PlotAxis axis{step * std::floor(low / step + 1e-9), step * std::ceil(high / step - 1e-9), {}};
  const auto steps = static_cast<int>(std::lround((axis.high - axis.low) / step));

  for (int i = 0; i <= steps; ++i) axis.marks.push_back(axis.low + i * step);
  return axis;
}

std::vector<double> marks_between(double low, double high, int count) {
  std::vector<double> marks = round_axis(low, high, count).marks;
  std::erase_if(marks, [&](double mark) { return mark < low || mark > high; });
  return marks;
}

PlotAxis decade_axis(double low, double high, int count) {
  PlotAxis axis{std::floor(std::log10(low) + 1e-9), std::ceil(std::log10(high) - 1e-9), {}};
  if (axis.high <= axis.low) axis.high = axis.low + 1;

  // Every second, third ... decade, for at most `count` steps.
  const int decades = static_cast<int>(axis.high - axis.low);
  const int step = std::max(1, (decades + count - 1) / count);

  for (int i = 0; i <= decades; i += step) axis.marks.push_back(axis.low + i);
  return axis;
}

ValueRange robust_range(const Image<double>& map) {
  std::vector<double> values = finite_values(map);
  if (values.empty()) return {};

  const double low = quantile(values, 0.01);
  return with_margin(low, quantile(values, 0.99));
}

void write_depth_preview(const fs::path& path, const Cloud& cloud) {
  require_ending(path, "preview", {".png"});
  write_file(path, depth_preview(cloud));
}

std::vector<std::uint8_t> depth_preview(const Cloud& cloud) {
  const Image<double> depth = converted<double>(cloud.z);
  const ColourMap colours = depth_colours();

  // Colours for the object, not for a wall far behind it.
  std::vector<double> depths = finite_values(depth);
  ValueRange range;
  if (!depths.empty()) {
    const auto [low, high] = range_of_object(depths);
    range = with_margin(low, high);
  }

  Canvas picture = coloured(depth, range, colours);

  // Shades the colours by the surface's slope.
  const Image<float> brightness = shading(cloud);
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (!std::isfinite(cloud.z(column, row))) return;

    const auto shaded = [&](std::uint8_t& level) {
      level = static_cast<std::uint8_t>(level * brightness(column, row) + 0.5F);
    };

    Colour& pixel = picture(column, row);
    shaded(pixel.red), shaded(pixel.green), shaded(pixel.blue);
  });

  return png_of(preview(part_of(picture, measured_part(depth)), range, "depth, mm", colours));
}

void write_map_preview(const fs::path& path, const Image<double>& map, const std::string& unit) {
  require_ending(path, "preview", {".png"});
  write_file(path, png_of(preview_of_map(map, robust_range(map), unit)));
}

void write_modulation_and_phase(const fs::path& path, const Image<double>& modulation,
                                const Image<double>& phase) {
  require_ending(path, "preview", {".png"});
  const Canvas left = preview_of_map(modulation, robust_range(modulation), "modulation");
  const Canvas right = preview_of_map(phase, {0, 2 * std::numbers::pi}, "phase, rad");

  Canvas both({left.width() + right.width(), std::max(left.height(), right.height())}, background);
  copy(left, both, 0, 0);
  copy(right, both, left.width(), 0);
  write_file(path, png_of(both));
}

void write_plot(const fs::path& path, const LinePlot& plot) {
  require_ending(path, "plot", {".png"});
  write_file(path, png_of(drawn(plot)));
}

void write_plot(const fs::path& path, const BarPlot& plot) {
  require_ending(path, "plot", {".png"});
  write_file(path, png_of(drawn(plot)));
}

}  // namespace slipstream
