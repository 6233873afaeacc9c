#include "slipstream/calibrate/pose_drawing.h"

#include <algorithm>

#include <opencv2/imgproc.hpp>

#include "slipstream/io/mat.h"

namespace slipstream {
namespace {

constexpr Colour green{90, 220, 110}, yellow{250, 210, 60}, red{255, 95, 80}, orange{255, 150, 50};

cv::Scalar scalar_of(Colour colour) {
  return {static_cast<double>(colour.red), static_cast<double>(colour.green),
          static_cast<double>(colour.blue)};
}

/// What is drawn, `scale` of its pixels for one of the camera's.
struct Drawing {
  cv::Mat picture;  ///< red, green, blue
  int scale = 1;
  int line = 2;  ///< width, pixels

  [[nodiscard]] cv::Point place(const Eigen::Vector2d& pixel) const {
    return {cvRound((pixel.x() + 0.5) * scale), cvRound((pixel.y() + 0.5) * scale)};
  }
};

Drawing enlarged(const Image<float>& picture, int width) {
  Drawing drawing;
  drawing.scale = std::max(1, (width + picture.width() - 1) / picture.width());
  cv::Mat grey, large;
  mat_of(picture).convertTo(grey, CV_8U);
  cv::resize(grey, large, {}, drawing.scale, drawing.scale, cv::INTER_LINEAR);
  cv::cvtColor(large, drawing.picture, cv::COLOR_GRAY2RGB);
  drawing.line = std::max(2, large.cols / 600);
  return drawing;
}

void dim_uncovered(const Drawing& drawing, const Image<std::uint8_t>& coverage) {
  cv::Mat uncovered, shade(drawing.picture.size(), CV_8UC3, cv::Scalar(20, 60, 140));
  cv::resize(mat_of(coverage) == 0, uncovered, drawing.picture.size(), 0, 0, cv::INTER_LINEAR);
  cv::addWeighted(drawing.picture, 0.65, shade, 0.35, 0, shade);
  shade.copyTo(drawing.picture, uncovered > 127);
}

void draw_outline(const Drawing& drawing, const std::vector<Eigen::Vector2d>& corners,
                  const cv::Scalar& colour) {
  std::vector<cv::Point> places, hull;
  for (const Eigen::Vector2d& corner : corners) places.push_back(drawing.place(corner));
  if (places.empty()) return;
  cv::convexHull(places, hull);
  cv::polylines(drawing.picture, hull, true, colour, drawing.line, cv::LINE_AA);
}

/// An arrow at each side of the picture, from its middle outwards.
void draw_tilts(const Drawing& drawing, const std::array<bool, 4>& tilted) {
  const int width = drawing.picture.cols, height = drawing.picture.rows;
  const int length = height / 14, gap = height / 40;
  const std::array<cv::Point, 4> outwards{cv::Point{-1, 0}, {1, 0}, {0, -1}, {0, 1}};
  for (std::size_t edge = 0; edge < outwards.size(); ++edge) {
    const cv::Point way = outwards[edge], across{way.y, way.x};
    const cv::Point tip{width / 2 + way.x * (width / 2 - gap),
                        height / 2 + way.y * (height / 2 - gap)};
    const cv::Point foot = tip - way * length;
    const std::array<cv::Point, 3> arrow{tip, foot + across * length, foot - across * length};
    cv::fillConvexPoly(drawing.picture, arrow, scalar_of(tilted[edge] ? green : orange),
                       cv::LINE_AA);
  }
}

}  // namespace

Colour colour_of(PoseState state) {
  if (state == PoseState::good || state == PoseState::taken) return green;
  return state == PoseState::moving || state == PoseState::known ? yellow : red;
}

Image<Colour> drawn_guide(const Image<float>& picture, const PoseVerdict& verdict,
                          const PoseNeeds& needs, const std::vector<BoardView>& taken, int width) {
  const Drawing drawing = enlarged(picture, width);
  if (!needs.enough) dim_uncovered(drawing, needs.coverage);
  for (const BoardView& view : taken) {
    draw_outline(drawing, view.camera, scalar_of(green) * 0.7);
  }
  if (verdict.board) {
    const cv::Scalar colour = scalar_of(colour_of(verdict.state));
    draw_outline(drawing, verdict.board->pixels, colour);
    for (const Eigen::Vector2d& corner : verdict.board->pixels) {
      cv::circle(drawing.picture, drawing.place(corner), 2 * drawing.line, colour, -1, cv::LINE_AA);
    }
  }
  draw_tilts(drawing, needs.tilted);
  Image<Colour> drawn({drawing.picture.cols, drawing.picture.rows});
  for (int row = 0; row < drawn.height(); ++row) {
    const cv::Vec3b* const from = drawing.picture.ptr<cv::Vec3b>(row);
    std::transform(from, from + drawn.width(), drawn.row(row), [](const cv::Vec3b& pixel) {
      return Colour{pixel[0], pixel[1], pixel[2]};
    });
  }
  return drawn;
}

}  // namespace slipstream
