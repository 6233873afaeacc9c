#include "slipstream/calibrate/coverage.h"

#include <algorithm>
#include <cmath>

#include <opencv2/imgproc.hpp>

#include "slipstream/io/mat.h"

namespace slipstream {

Image<std::uint8_t> coverage_map(const std::vector<BoardView>& views, Device device, Size size) {
  constexpr int columns = 100;
  const double cells_per_pixel = static_cast<double>(columns) / size.width;
  const int rows = std::max(1, static_cast<int>(std::lround(size.height * cells_per_pixel)));
  cv::Mat counts(rows, columns, CV_8U, cv::Scalar(0));
  for (const BoardView& view : views) {
    std::vector<cv::Point> cells, hull;
    for (const Eigen::Vector2d& pixel : device == Device::camera ? view.camera : view.projector) {
      if (!pixel.allFinite()) continue;
      const Eigen::Vector2d cell = pixel * cells_per_pixel;
      cells.emplace_back(cvRound(cell.x()), cvRound(cell.y()));
    }
    if (cells.empty()) continue;
    cv::convexHull(cells, hull);
    cv::Mat board(counts.size(), CV_8U, cv::Scalar(0));
    cv::fillConvexPoly(board, hull, cv::Scalar(1));
    counts += board;
  }
  return image_from<std::uint8_t>(counts);
}

double covered_share(const Image<std::uint8_t>& coverage) {
  const auto covered =
      std::count_if(coverage.begin(), coverage.end(), [](std::uint8_t count) { return count > 0; });
  return static_cast<double>(covered) / static_cast<double>(coverage.pixel_count());
}

}  // namespace slipstream
