#include "slipstream/io/plot.h"

#include <opencv2/imgproc.hpp>

#include "slipstream/base/colour.h"
#include "slipstream/base/statistics.h"
#include "slipstream/base/throw_if-inl.h"
#include "slipstream/cloud/surface.h"
#include "slipstream/io/detail/pictures.h"
#include "slipstream/io/file.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

// Pictures have their channels in the order red, green, blue.
const cv::Scalar paper(255, 255, 255);
const cv::Scalar ink(60, 60, 60);
const cv::Scalar grid(228, 228, 228);
/// Blue, red, green, violet, orange, cyan: distinguishable for most readers.
const std::array<cv::Scalar, 6> line_colours{cv::Scalar(30, 110, 180), cv::Scalar(200, 50, 50),
                                             cv::Scalar(40, 140, 60),  cv::Scalar(130, 70, 170),
                                             cv::Scalar(230, 130, 0),  cv::Scalar(30, 160, 170)};

constexpr int width = 800, height = 520;
constexpr int legend_line = 18;  // below the axes, where it hides no curve
constexpr int left = 100, right = width - 30, top = 50, bottom = height - 70;

int text_width(const std::string& text, double size) {
  int baseline = 0;
  return cv::getTextSize(text, cv::FONT_HERSHEY_SIMPLEX, size, 1, &baseline).width;
}

/// `size`: font size, 0.45 for ordinary text.
void draw_text(cv::Mat& picture, const std::string& text, cv::Point at, double size,
               const cv::Scalar& ink) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, ink, 1, cv::LINE_AA);
}

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
        page_(height + legend_lines * legend_line, width, CV_8UC3, paper) {
    for (const double mark : x_.marks) {
      const int at = x_place(mark);
      cv::line(page_, {at, top}, {at, bottom}, grid);
      const std::string text = text_of_mark(mark);
      draw_text(page_, text, {at - text_width(text, 0.42) / 2, bottom + 20}, 0.42, ink);
    }
    for (const double mark : y_.marks) {
      const int at = y_mark_place(mark);
      cv::line(page_, {left, at}, {right, at}, grid);
      const std::string text =
          y_scale == PlotScale::logarithmic ? fmt::format("1e{:.0f}", mark) : text_of_mark(mark);
      draw_text(page_, text, {left - 8 - text_width(text, 0.42), at + 4}, 0.42, ink);
    }
    cv::rectangle(page_, {left, top}, {right, bottom}, ink);
    draw_text(page_, plot.title, {left, 22}, 0.5, ink);
    draw_text(page_, plot.y_label, {8, top - 10}, 0.42, ink);
    const int middle = (left + right - text_width(plot.x_label, 0.45)) / 2;
    draw_text(page_, plot.x_label, {middle, height - 18}, 0.45, ink);
  }

  [[nodiscard]] cv::Point place(double x, double y) const {
    return {x_place(x), y_mark_place(y_scale_ == PlotScale::logarithmic ? std::log10(y) : y)};
  }
  [[nodiscard]] bool shows(double x, double y) const {
    return std::isfinite(x) && std::isfinite(y) && (y_scale_ == PlotScale::linear || y > 0);
  }

  void explain(int line, const std::string& label, const cv::Scalar& colour) {
    const int at = height + line * legend_line;
    cv::line(page_, {left, at - 4}, {left + 25, at - 4}, colour, 2, cv::LINE_AA);
    draw_text(page_, label, {left + 32, at}, 0.42, ink);
  }

  [[nodiscard]] cv::Mat& picture() { return page_; }

 private:
  [[nodiscard]] int x_place(double x) const {
    return left + static_cast<int>(std::lround((x - x_.low) / (x_.high - x_.low) * (right - left)));
  }
  [[nodiscard]] int y_mark_place(double y) const {
    const double share = std::clamp((y - y_.low) / (y_.high - y_.low), -0.01, 1.01);
    return bottom - static_cast<int>(std::lround(share * (bottom - top)));
  }

  PlotAxis x_, y_;
  PlotScale y_scale_;
  cv::Mat page_;
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

cv::Mat drawn(const LinePlot& plot) {
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
  const auto labelled =
      std::ranges::count_if(plot.lines, [](const PlotLine& line) { return !line.label.empty(); });
  Axes page(plot, round_axis(x.low, x.high, 8),
            logarithmic ? decade_axis(y.low, y.high, 10) : round_axis(y.low, y.high, 8),
            plot.y_scale, static_cast<int>(labelled));
  int explained = 0;
  for (std::size_t k = 0; k < plot.lines.size(); ++k) {
    const PlotLine& line = plot.lines[k];
    const cv::Scalar& colour = line_colours[k % line_colours.size()];
    for (std::size_t i = 0; i < line.x.size(); ++i) {
      if (!page.shows(line.x[i], line.y[i])) continue;
      const cv::Point here = page.place(line.x[i], line.y[i]);
      if (line.x.size() <= 40) cv::circle(page.picture(), here, 3, colour, cv::FILLED, cv::LINE_AA);
      if (i == 0 || !page.shows(line.x[i - 1], line.y[i - 1])) continue;
      cv::line(page.picture(), page.place(line.x[i - 1], line.y[i - 1]), here, colour, 1,
               cv::LINE_AA);
    }
    if (!line.label.empty()) page.explain(explained++, line.label, colour);
  }
  return page.picture();
}

cv::Mat drawn(const BarPlot& plot) {
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
    cv::rectangle(page.picture(), page.place(from, plot.heights[i]),
                  page.place(from + step, 0) - cv::Point(1, 0), line_colours[0], cv::FILLED);
  }
  return page.picture();
}

const cv::Scalar background(40, 42, 46);
const cv::Scalar page_ink(225, 225, 225);
constexpr int smallest_height = 240;  // of a page

/// Converts values to colours; non-finite pixels get the background.
cv::Mat coloured(const Image<double>& map, const ValueRange& range, const ColourMap& colours) {
  cv::Mat picture(map.height(), map.width(), CV_8UC3, background);
  for_each_pixel_in_order(map.size(), [&](int column, int row) {
    const double value = map(column, row);
    if (!std::isfinite(value)) return;
    const double level = 255 * (value - range.low) / (range.high - range.low);
    const auto& [red, green, blue] = colours[cv::saturate_cast<std::uint8_t>(level)];
    picture.at<cv::Vec3b>(row, column) = {red, green, blue};
  });
  return picture;
}

/// The picture with a colour bar at its right, labelled at round values.
cv::Mat with_scale(const cv::Mat& picture, const ValueRange& range, const std::string& unit,
                   const ColourMap& colours) {
  constexpr int bar_width = 22, margin = 16, label_width = 92;
  const int height = std::max(picture.rows, smallest_height);
  cv::Mat page(height, picture.cols + margin + bar_width + label_width, CV_8UC3, background);
  picture.copyTo(page(cv::Rect(0, 0, picture.cols, picture.rows)));

  const int left = picture.cols + margin, top = 40, bottom = height - 20;
  Image<double> ramp({bar_width, bottom - top});
  const auto value_at = [&](int y) {
    return range.low + (range.high - range.low) * y / (bottom - top - 1);
  };
  for (int y = 0; y < ramp.height(); ++y) std::fill_n(ramp.row(y), bar_width, value_at(y));
  coloured(ramp, range, colours).copyTo(page(cv::Rect(left, top, bar_width, bottom - top)));
  draw_text(page, unit, {left, top - 14}, 0.5, page_ink);

  for (const double mark : marks_between(range.low, range.high, 8)) {
    const double share = (mark - range.low) / (range.high - range.low);
    const int y = top + static_cast<int>(std::lround(share * (bottom - top - 1)));
    const int right = left + bar_width;
    cv::line(page, {right, y}, {right + 5, y}, page_ink);
    draw_text(page, fmt::format("{:g}", mark), {right + 9, y + 4}, 0.42, page_ink);
  }
  return page;
}

std::vector<std::uint8_t> png_of(const cv::Mat& picture) {
  const ImageView<const std::uint8_t> samples(picture.data, {3 * picture.cols, picture.rows});
  return png_file_of(PictureView(samples, 3));
}

std::vector<std::uint8_t> preview(cv::Mat picture, const ValueRange& range, const std::string& unit,
                                  const ColourMap& colours) {
  constexpr int longest_side = 1000;
  const int side = std::max(picture.cols, picture.rows);
  if (side > longest_side) {
    const double scale = static_cast<double>(longest_side) / side;
    cv::resize(picture, picture, {}, scale, scale, cv::INTER_AREA);
  }
  return png_of(with_scale(picture, range, unit, colours));
}

}  // namespace

PlotAxis round_axis(double low, double high, int count) {
  if (!(high > low)) {
    const double margin = low == 0 ? 1 : 0.1 * std::abs(low);
    low -= margin;
    high = low + 2 * margin;
  }
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
  const int decades = static_cast<int>(axis.high - axis.low);
  const int step = std::max(1, (decades + count - 1) / count);
  for (int i = 0; i <= decades; i += step) axis.marks.push_back(axis.low + i);
  return axis;
}

ValueRange robust_range(const Image<double>& map) {
  std::vector<double> values = finite_values(map);
  if (values.empty()) return {};
  const double low = quantile(values, 0.01), high = quantile(values, 0.99);
  const double margin = std::max(0.02 * (high - low), 1e-3 * std::abs(high) + 1e-9);
  return {low - margin, high + margin};
}

void write_depth_preview(const fs::path& path, const Cloud& cloud) {
  require_ending(path, "preview", {".png"});
  write_file(path, depth_preview(cloud));
}

std::vector<std::uint8_t> depth_preview(const Cloud& cloud) {
  const Image<double> depth = converted<double>(cloud.z);
  const ValueRange range = robust_range(depth);
  const ColourMap colours = depth_colours();
  cv::Mat picture = coloured(depth, range, colours);
  const Image<float> brightness = shading(cloud);
  for_each_pixel_in_order(cloud.size(), [&](int column, int row) {
    if (!std::isfinite(cloud.z(column, row))) return;
    auto& pixel = picture.at<cv::Vec3b>(row, column);
    pixel = cv::Vec3f(pixel) * brightness(column, row);
  });
  return preview(std::move(picture), range, "depth, mm", colours);
}

void write_map_preview(const fs::path& path, const Image<double>& map, const std::string& unit) {
  require_ending(path, "preview", {".png"});
  const ValueRange range = robust_range(map);
  ColourMap colours = depth_colours();
  std::reverse(colours.begin(), colours.end());  // large values stand out, like near depths
  cv::Mat picture = coloured(map, range, colours);
  const int times = smallest_height / std::max({map.width(), map.height(), 1});
  if (times > 1) cv::resize(picture, picture, {}, times, times, cv::INTER_NEAREST);
  write_file(path, preview(std::move(picture), range, unit, colours));
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
