#include "calibrate/residual_pictures.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <fmt/core.h>

#include "base/statistics.h"
#include "calibrate/opencv.h"

namespace slipstream {
namespace {

// Red, green, blue.
const cv::Scalar paper(255, 255, 255);
const cv::Scalar ink(40, 50, 60);
const cv::Scalar faint(215, 215, 215);

/// The first eight are chosen by eye; further ones follow by the golden angle of the hue, dark and
/// light in turn, so that neighbours differ.
cv::Scalar colour_of_pose(std::size_t pose) {
  static const std::array<cv::Scalar, 8> colours{
      cv::Scalar(31, 119, 180),  cv::Scalar(255, 127, 14),  cv::Scalar(44, 160, 44),
      cv::Scalar(214, 39, 40),   cv::Scalar(148, 103, 189), cv::Scalar(140, 86, 75),
      cv::Scalar(227, 119, 194), cv::Scalar(127, 127, 127)};
  if (pose < colours.size()) return colours[pose];

  constexpr double golden_angle = 137.508;  // degrees
  const double hue = std::fmod(golden_angle * static_cast<double>(pose), 360);
  const double brightness = pose % 2 == 0 ? 0.85 : 0.55;
  cv::Mat3f colour(1, 1, cv::Vec3f(static_cast<float>(hue), 0.85F, static_cast<float>(brightness)));
  cv::cvtColor(colour, colour, cv::COLOR_HSV2RGB);
  return 255 * cv::Scalar(colour(0, 0));
}

void write(cv::Mat& picture, const std::string& text, cv::Point at) {
  cv::putText(picture, text, at, cv::FONT_HERSHEY_SIMPLEX, 0.45, ink, 1, cv::LINE_AA);
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

/// Cells covered by more boards are darker.
cv::Mat drawn_coverage(const Image<std::uint8_t>& coverage, cv::Size size) {
  cv::Mat picture(coverage.height(), coverage.width(), CV_8UC3);
  for_each_pixel_in_order(coverage.size(), [&](int column, int row) {
    const double share = std::min(1.0, coverage(column, row) / 8.0);

    // From white without a board to blue with eight or more.
    const auto fade = [&](double dark) {
      return cv::saturate_cast<std::uint8_t>(255 - share * (255 - dark));
    };
    picture.at<cv::Vec3b>(row, column) = {fade(150), fade(190), fade(230)};
  });

  cv::Mat enlarged;
  cv::resize(picture, enlarged, size, 0, 0, cv::INTER_NEAREST);
  return enlarged;
}

}  // namespace

Image<Colour> residual_map(const BoardViews& boards, const BoardViews& views,
                           const Residuals& residuals, Device device, Size size) {
  constexpr int width = 800, legend = 34;
  constexpr double arrow = 24;  // pixels, of a usual residual

  // The picture, with the coverage as shading, above a strip for the legend.
  const double scale = static_cast<double>(width) / size.width;
  const int height = cvRound(scale * size.height);
  cv::Mat picture(height + legend, width, CV_8UC3, paper);
  drawn_coverage(coverage_map(boards, device, size), {width, height})
      .copyTo(picture(cv::Rect(0, 0, width, height)));
  cv::rectangle(picture, {0, 0, width, height}, faint);

  // Each residual as an arrow from the observed corner.
  const double enlarged = arrow / usual_length(residuals);
  for (std::size_t v = 0; v < views.size(); ++v) {
    const auto& seen = corners_of(views[v], device);
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (!residuals[v][i].allFinite()) continue;

      const Eigen::Vector2d from = scale * seen[i];
      const Eigen::Vector2d to = from + enlarged * residuals[v][i];
      cv::arrowedLine(picture, nearest_pixel(from), nearest_pixel(to), colour_of_pose(v), 1,
                      cv::LINE_AA, 0, 0.25);
    }
  }

  // The scale bar.
  const double unit = round_below(2 * arrow / enlarged);
  const int length = cvRound(unit * enlarged), y = height + legend / 2;
  cv::line(picture, {12, y}, {12 + length, y}, ink, 2);
  write(picture, fmt::format("{:g} px; shade: number of boards", unit), {24 + length, y + 5});
  return image_from<Colour>(picture);
}

Image<Colour> residual_scatter(const BoardViews& views, const Residuals& residuals) {
  constexpr int side = 420, names_width = 150;
  const double reach = 1.6 * usual_length(residuals);
  const double scale = side / 2.0 / reach;
  const cv::Point centre(side / 2, side / 2);
  constexpr int line = 18, last_lines = 50;
  const int height = std::max(side, line * static_cast<int>(views.size()) + last_lines);
  cv::Mat picture(height, side + names_width, CV_8UC3, paper);

  // Axes, and a ring that shows the scale.
  const double ring = round_below(reach);
  cv::line(picture, {0, centre.y}, {side, centre.y}, faint);
  cv::line(picture, {centre.x, 0}, {centre.x, side}, faint);
  cv::circle(picture, centre, cvRound(ring * scale), faint, 1, cv::LINE_AA);

  // A dot for each residual within reach, and the names of the poses.
  const cv::Rect field(0, 0, side, side);
  for (std::size_t v = 0; v < views.size(); ++v) {
    for (const Eigen::Vector2d& residual : residuals[v]) {
      if (!residual.allFinite()) continue;

      const cv::Point at = centre + nearest_pixel(scale * residual);
      if (field.contains(at)) {
        cv::circle(picture, at, 2, colour_of_pose(v), cv::FILLED, cv::LINE_AA);
      }
    }

    const int y = 20 + line * static_cast<int>(v);
    cv::circle(picture, {side + 14, y - 4}, 4, colour_of_pose(v), cv::FILLED, cv::LINE_AA);
    write(picture, views[v].name, {side + 26, y});
  }

  write(picture, fmt::format("ring: {:g} px", ring), {side + 10, height - 10});
  return image_from<Colour>(picture);
}

Image<Colour> drawn_residual(const BoardViews& boards, const Lens& lens, Device device) {
  constexpr int across = 24, down = 18;
  BoardView grid;
  PixelPlaces shifts;

  for_each_pixel_in_order({across, down}, [&](int column, int row) {
    const Eigen::Vector2d pixel((column + 0.5) * lens.size.width / across,
                                (row + 0.5) * lens.size.height / down);
    grid.camera.push_back(pixel);
    grid.projector.push_back(pixel);
    shifts.push_back(shift_at(lens.residual, pixel));
  });

  return residual_map(boards, {grid}, {shifts}, device, lens.size);
}

}  // namespace slipstream
