#include "slipstream/io/preview.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>

#include "slipstream/cloud/normals.h"
#include "slipstream/error/error.h"
#include "slipstream/image/converted.h"
#include "slipstream/image/quantile.h"
#include "slipstream/io/file.h"
#include "slipstream/io/mat.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

const cv::Scalar background(46, 42, 40);
const cv::Scalar ink(225, 225, 225);

/// Values to colours, pixels that are not finite to the background.
cv::Mat coloured(const Image<double>& map, const ValueRange& range) {
  cv::Mat grey(map.height(), map.width(), CV_8U, cv::Scalar(0));
  cv::Mat known(map.height(), map.width(), CV_8U, cv::Scalar(0));
  for (int row = 0; row < map.height(); ++row) {
    for (int column = 0; column < map.width(); ++column) {
      const double value = map(column, row);
      if (!std::isfinite(value)) continue;
      const double level = 255 * (value - range.low) / (range.high - range.low);
      grey.at<std::uint8_t>(row, column) = cv::saturate_cast<std::uint8_t>(level);
      known.at<std::uint8_t>(row, column) = 255;
    }
  }
  cv::Mat colours, picture(grey.size(), CV_8UC3, background);
  cv::applyColorMap(grey, colours, cv::COLORMAP_TURBO);
  colours.copyTo(picture, known);
  return picture;
}

/// Darkens what is turned away from a light above the viewer's left shoulder.
void shade(cv::Mat& picture, const Cloud& cloud) {
  const Normals normals = surface_normals(cloud);
  const cv::Vec3f light = cv::normalize(cv::Vec3f(-0.4F, -0.5F, -1.0F));
  for (int row = 0; row < picture.rows; ++row) {
    for (int column = 0; column < picture.cols; ++column) {
      const cv::Vec3f normal(normals.x(column, row), normals.y(column, row),
                             normals.z(column, row));
      const float facing = normal.dot(light);
      if (std::isnan(facing)) continue;
      const double brightness = 0.3 + 0.7 * std::max(facing, 0.0F);
      auto& pixel = picture.at<cv::Vec3b>(row, column);
      for (int channel = 0; channel < 3; ++channel) {
        pixel[channel] = cv::saturate_cast<std::uint8_t>(brightness * pixel[channel]);
      }
    }
  }
}

/// The round number (1, 2 or 5 times a power of ten) nearest above span / count.
double round_step(double span, int count) {
  const double raw = span / count;
  const double power = std::pow(10, std::floor(std::log10(raw)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (raw <= factor * power) return factor * power;
  }
  return 10 * power;
}

void draw_text(cv::Mat& picture, const std::string& text, cv::Point at, double size) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, size, ink, 1, cv::LINE_AA);
}

/// The picture with a bar of its colours at its right, labelled at round values.
cv::Mat with_scale(const cv::Mat& picture, const ValueRange& range, const std::string& unit) {
  constexpr int bar_width = 22, margin = 16, label_width = 92, smallest_height = 240;
  const int height = std::max(picture.rows, smallest_height);
  cv::Mat page(height, picture.cols + margin + bar_width + label_width, CV_8UC3, background);
  picture.copyTo(page(cv::Rect(0, 0, picture.cols, picture.rows)));

  const int left = picture.cols + margin, top = 40, bottom = height - 20;
  Image<double> ramp({bar_width, bottom - top});
  const auto value_at = [&](int y) {
    return range.low + (range.high - range.low) * y / (bottom - top - 1);
  };
  for (int y = 0; y < ramp.height(); ++y) std::fill_n(ramp.row(y), bar_width, value_at(y));
  coloured(ramp, range).copyTo(page(cv::Rect(left, top, bar_width, bottom - top)));
  draw_text(page, unit, {left, top - 14}, 0.5);

  const double step = round_step(range.high - range.low, 8);
  const int decimals = std::max(0, -static_cast<int>(std::floor(std::log10(step) + 1e-9)));
  for (double tick = std::ceil(range.low / step) * step; tick <= range.high; tick += step) {
    const double share = (tick - range.low) / (range.high - range.low);
    const int y = top + static_cast<int>(std::lround(share * (bottom - top - 1)));
    const int right = left + bar_width;
    cv::line(page, {right, y}, {right + 5, y}, ink);
    draw_text(page, fmt::format("{:.{}f}", tick, decimals), {right + 9, y + 4}, 0.42);
  }
  return page;
}

void write_page(const fs::path& path, cv::Mat picture, const ValueRange& range,
                const std::string& unit) {
  if (lower_case_extension(path) != ".png") {
    throw Error(fmt::format("{}: previews are PNG files; use the ending .png", path.string()));
  }
  constexpr int longest_side = 1000;
  const int side = std::max(picture.cols, picture.rows);
  if (side > longest_side) {
    const double scale = static_cast<double>(longest_side) / side;
    cv::resize(picture, picture, {}, scale, scale, cv::INTER_AREA);
  }
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", with_scale(picture, range, unit), bytes);
  write_file(path, bytes);
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
  cv::Mat picture = coloured(depth, range);
  shade(picture, cloud);
  write_page(path, std::move(picture), range, "depth, mm");
}

void write_map_preview(const fs::path& path, const Image<double>& map, const std::string& unit) {
  const ValueRange range = robust_range(map);
  write_page(path, coloured(map, range), range, unit);
}

}  // namespace slipstream
