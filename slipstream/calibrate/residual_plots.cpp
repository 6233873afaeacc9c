#include "slipstream/calibrate/residual_plots.h"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>
#include <opencv2/imgproc.hpp>

#include "slipstream/base/quantile.h"
#include "slipstream/calibrate/coverage.h"
#include "slipstream/io/drawing.h"
#include "slipstream/io/mat.h"

namespace slipstream {
namespace {

const cv::Scalar paper(255, 255, 255);
const cv::Scalar ink(60, 50, 40);
const cv::Scalar faint(215, 215, 215);

cv::Scalar colour_of_pose(std::size_t pose) {
  static const std::array<cv::Scalar, 8> colours{
      cv::Scalar(180, 119, 31),  cv::Scalar(14, 127, 255),  cv::Scalar(44, 160, 44),
      cv::Scalar(40, 39, 214),   cv::Scalar(189, 103, 148), cv::Scalar(75, 86, 140),
      cv::Scalar(194, 119, 227), cv::Scalar(127, 127, 127)};
  return colours[pose % colours.size()];
}

/// 1, 2 or 5 times a power of ten, not above `value`.
double round_below(double value) {
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double factor : {5.0, 2.0}) {
    if (factor * power <= value) return factor * power;
  }
  return power;
}

/// The length that 95 % of the residuals do not exceed.
double usual_length(const Residuals& residuals) {
  std::vector<double> lengths;
  for (const auto& view : residuals) {
    for (const Eigen::Vector2d& residual : view) {
      if (residual.allFinite()) lengths.push_back(residual.norm());
    }
  }
  return lengths.empty() ? 1 : std::max(quantile(lengths, 0.95), 1e-6);
}

cv::Point point_of(const Eigen::Vector2d& place) {
  return {cvRound(place.x()), cvRound(place.y())};
}

/// Cells that more boards cover are darker.
cv::Mat drawn_coverage(const Image<std::uint8_t>& coverage, cv::Size size) {
  cv::Mat picture(coverage.height(), coverage.width(), CV_8UC3);
  for (int row = 0; row < coverage.height(); ++row) {
    for (int column = 0; column < coverage.width(); ++column) {
      const double share = std::min(1.0, coverage(column, row) / 8.0);
      const auto fade = [&](double dark) {
        return cv::saturate_cast<std::uint8_t>(255 - share * (255 - dark));
      };
      picture.at<cv::Vec3b>(row, column) = {fade(230), fade(190), fade(150)};
    }
  }
  cv::Mat enlarged;
  cv::resize(picture, enlarged, size, 0, 0, cv::INTER_NEAREST);
  return enlarged;
}

}  // namespace

void write_residual_map(const std::filesystem::path& path, const std::vector<BoardView>& views,
                        const Residuals& residuals, Device device, Size size) {
  constexpr int width = 800, legend = 34;
  constexpr double arrow = 24;  // pixels, of a usual residual
  const double scale = static_cast<double>(width) / size.width;
  const int height = cvRound(scale * size.height);
  cv::Mat picture(height + legend, width, CV_8UC3, paper);
  drawn_coverage(coverage_map(views, device, size), {width, height})
      .copyTo(picture(cv::Rect(0, 0, width, height)));
  cv::rectangle(picture, {0, 0, width, height}, faint);

  const double enlarged = arrow / usual_length(residuals);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const auto& seen = device == Device::camera ? views[v].camera : views[v].projector;
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (!residuals[v][i].allFinite()) continue;
      const Eigen::Vector2d from = scale * seen[i];
      const Eigen::Vector2d to = from + enlarged * residuals[v][i];
      cv::arrowedLine(picture, point_of(from), point_of(to), colour_of_pose(v), 1, cv::LINE_AA, 0,
                      0.25);
    }
  }
  const double unit = round_below(2 * arrow / enlarged);
  const int length = cvRound(unit * enlarged), y = height + legend / 2;
  cv::line(picture, {12, y}, {12 + length, y}, ink, 2);
  draw_text(picture, fmt::format("{:g} px; shade: how many boards", unit), {24 + length, y + 5},
            0.45, ink);
  write_png(path, picture);
}

void write_residual_scatter(const std::filesystem::path& path, const std::vector<BoardView>& views,
                            const Residuals& residuals) {
  constexpr int side = 420, names_width = 150;
  const double reach = 1.6 * usual_length(residuals);
  const double scale = side / 2.0 / reach;
  const cv::Point centre(side / 2, side / 2);
  cv::Mat picture(side, side + names_width, CV_8UC3, paper);
  const double ring = round_below(reach);
  cv::line(picture, {0, centre.y}, {side, centre.y}, faint);
  cv::line(picture, {centre.x, 0}, {centre.x, side}, faint);
  cv::circle(picture, centre, cvRound(ring * scale), faint, 1, cv::LINE_AA);
  const cv::Rect field(0, 0, side, side);
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (const Eigen::Vector2d& residual : residuals[v]) {
      if (!residual.allFinite()) continue;
      const cv::Point at = centre + point_of(scale * residual);
      if (field.contains(at)) {
        cv::circle(picture, at, 2, colour_of_pose(v), cv::FILLED, cv::LINE_AA);
      }
    }
    const int y = 20 + 18 * static_cast<int>(v);
    if (y > side - 30) continue;
    cv::circle(picture, {side + 14, y - 4}, 4, colour_of_pose(v), cv::FILLED, cv::LINE_AA);
    draw_text(picture, views[v].name, {side + 26, y}, 0.45, ink);
  }
  draw_text(picture, fmt::format("ring: {:g} px", ring), {side + 10, side - 10}, 0.45, ink);
  write_png(path, picture);
}

}  // namespace slipstream
