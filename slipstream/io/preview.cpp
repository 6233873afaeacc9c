#include "slipstream/io/preview.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "slipstream/base/colour_map.h"
#include "slipstream/base/converted.h"
#include "slipstream/base/quantile.h"
#include "slipstream/cloud/shading.h"
#include "slipstream/io/drawing.h"
#include "slipstream/io/file.h"
#include "slipstream/io/mat.h"
#include "slipstream/io/plot.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

const cv::Scalar background(46, 42, 40);
const cv::Scalar page_ink(225, 225, 225);
constexpr int smallest_height = 240;  // of a page

/// Values to colours, pixels that are not finite to the background.
cv::Mat coloured(const Image<double>& map, const ValueRange& range, const ColourMap& colours) {
  cv::Mat picture(map.height(), map.width(), CV_8UC3, background);
  for (int row = 0; row < map.height(); ++row) {
    for (int column = 0; column < map.width(); ++column) {
      const double value = map(column, row);
      if (!std::isfinite(value)) continue;
      const double level = 255 * (value - range.low) / (range.high - range.low);
      const Colour& colour = colours[cv::saturate_cast<std::uint8_t>(level)];
      picture.at<cv::Vec3b>(row, column) = {colour.blue, colour.green, colour.red};
    }
  }
  return picture;
}

/// What is much stands out, as what is near does in depth.
ColourMap map_colours() {
  ColourMap colours = depth_colours();
  std::reverse(colours.begin(), colours.end());
  return colours;
}

void shade(cv::Mat& picture, const Cloud& cloud) {
  const Image<float> brightness = shading(cloud);
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) {
      if (!std::isfinite(cloud.z(column, row))) continue;
      auto& pixel = picture.at<cv::Vec3b>(row, column);
      pixel = cv::Vec3f(pixel) * brightness(column, row);
    }
  }
}

/// The picture with a bar of its colours at its right, labelled at round values.
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

void write_preview(const fs::path& path, cv::Mat picture, const ValueRange& range,
                   const std::string& unit, const ColourMap& colours) {
  require_ending(path, "preview", {".png"});
  constexpr int longest_side = 1000;
  const int side = std::max(picture.cols, picture.rows);
  if (side > longest_side) {
    const double scale = static_cast<double>(longest_side) / side;
    cv::resize(picture, picture, {}, scale, scale, cv::INTER_AREA);
  }
  write_png(path, with_scale(picture, range, unit, colours));
}

}  // namespace

ValueRange robust_range(const Image<double>& map) {
  std::vector<double> values = finite_values(map);
  if (values.empty()) return {};
  const double low = quantile(values, 0.01), high = quantile(values, 0.99);
  const double margin = std::max(0.02 * (high - low), 1e-3 * std::abs(high) + 1e-9);
  return {low - margin, high + margin};
}

void write_depth_preview(const fs::path& path, const Cloud& cloud) {
  const Image<double> depth = converted<double>(cloud.z);
  const ValueRange range = robust_range(depth);
  const ColourMap colours = depth_colours();
  cv::Mat picture = coloured(depth, range, colours);
  shade(picture, cloud);
  write_preview(path, std::move(picture), range, "depth, mm", colours);
}

void write_map_preview(const fs::path& path, const Image<double>& map, const std::string& unit) {
  const ValueRange range = robust_range(map);
  const ColourMap colours = map_colours();
  cv::Mat picture = coloured(map, range, colours);
  const int times = smallest_height / std::max({map.width(), map.height(), 1});
  if (times > 1) cv::resize(picture, picture, {}, times, times, cv::INTER_NEAREST);
  write_preview(path, std::move(picture), range, unit, colours);
}

}  // namespace slipstream
