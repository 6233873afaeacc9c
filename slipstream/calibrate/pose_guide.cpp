#include "slipstream/calibrate/pose_guide.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "slipstream/base/error.h"
#include "slipstream/base/quantile.h"
#include "slipstream/calibrate/coverage.h"
#include "slipstream/calibrate/first_guess.h"
#include "slipstream/calibrate/quiet_opencv.h"
#include "slipstream/io/mat.h"

namespace slipstream {
namespace {

/// Grey levels of the board's pixels, all within the hull of its corners.
std::vector<float> greys_of(const Image<float>& picture, const BoardCorners& board) {
  std::vector<cv::Point> corners, hull;
  for (const Eigen::Vector2d& pixel : board.pixels) {
    corners.emplace_back(cvRound(pixel.x()), cvRound(pixel.y()));
  }
  cv::convexHull(corners, hull);
  cv::Mat inside(picture.height(), picture.width(), CV_8U, cv::Scalar(0));
  cv::fillConvexPoly(inside, hull, cv::Scalar(1));
  std::vector<float> greys;
  for (int row = 0; row < picture.height(); ++row) {
    for (int column = 0; column < picture.width(); ++column) {
      if (inside.at<std::uint8_t>(row, column) != 0) greys.push_back(picture(column, row));
    }
  }
  return greys;
}

/// Mean distance of the corners that both have, pixels; none where there is no such corner.
std::optional<double> distance(const BoardCorners& seen, const BoardView& taken) {
  std::map<int, Eigen::Vector2d> before;
  for (std::size_t i = 0; i < taken.places.size(); ++i) {
    before.emplace(taken.places[i], taken.camera[i]);
  }
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < seen.places.size(); ++i) {
    const auto corner = before.find(seen.places[i]);
    if (corner == before.end()) continue;
    sum += (seen.pixels[i] - corner->second).norm();
    ++count;
  }
  if (count == 0) return std::nullopt;
  return sum / count;
}

const BoardView* same_pose(const BoardCorners& seen, const std::vector<BoardView>& taken,
                           int width) {
  constexpr double near = 0.03;
  const auto known = std::find_if(taken.begin(), taken.end(), [&](const BoardView& view) {
    return distance(seen, view).value_or(width) < near * width;
  });
  return known == taken.end() ? nullptr : &*known;
}

/// What the light and the focus say; none where both serve.
std::optional<PoseVerdict> unfit(const FringeFreePictures& pictures, const CalibrationBoard& board,
                                 const BoardCorners& seen) {
  constexpr float full_scale = 254.5F;
  constexpr double most_saturated = 0.25, least_white = 40;
  std::vector<float> greys = greys_of(pictures.brightest, seen);
  if (greys.empty()) return PoseVerdict{PoseState::unseen, "the board is too small", seen};
  const auto saturated =
      std::count_if(greys.begin(), greys.end(), [](float grey) { return grey >= full_scale; });
  const double share = static_cast<double>(saturated) / static_cast<double>(greys.size());
  if (share >= most_saturated) {
    return PoseVerdict{
        PoseState::overexposed,
        fmt::format("{:.0f} % of the board is saturated: expose less, close the aperture or dim "
                    "the projector",
                    100 * share),
        seen};
  }
  const double white = quantile(greys, 0.9);
  if (white < least_white) {
    return PoseVerdict{PoseState::dark,
                       fmt::format("the board's white is {:.0f} of 255 grey levels: expose longer, "
                                   "open the aperture or hold it into the projector's light",
                                   white),
                       seen};
  }
  const EdgeSoftness edges = edge_softness(pictures.mean, board, seen.places, seen.pixels);
  if (is_soft(edges)) {
    return PoseVerdict{
        PoseState::blurred,
        fmt::format("edges are {:.1f} pixels wide: focus the camera on the board, or "
                    "hold it still",
                    edges.pixels),
        seen};
  }
  return std::nullopt;
}

/// A camera's lens, without distortion, by what it saw of boards: enough to tell how they lean.
Lens lens_by(const std::vector<BoardView>& views, const std::vector<Eigen::Vector3d>& printed,
             Size size) {
  std::vector<std::vector<cv::Point3f>> board;
  std::vector<std::vector<cv::Point2f>> pixels;
  for (const BoardView& view : views) {
    board.emplace_back();
    pixels.emplace_back();
    for (std::size_t i = 0; i < view.places.size(); ++i) {
      const Eigen::Vector3f place = printed[static_cast<std::size_t>(view.places[i])].cast<float>();
      const Eigen::Vector2f pixel = view.camera[i].cast<float>();
      board.back().emplace_back(place.x(), place.y(), place.z());
      pixels.back().emplace_back(pixel.x(), pixel.y());
    }
  }
  const QuietOpenCv quiet;
  const cv::Mat found = cv::initCameraMatrix2D(board, pixels, {size.width, size.height}, 1);
  // Boards that hardly lean say nothing of it.
  const double focal = found.at<double>(0, 0), usual = 1.3 * size.width;
  const double used = focal > 0.5 * size.width && focal < 10 * size.width ? focal : usual;
  Lens lens;
  lens.size = size;
  lens.intrinsic << used, 0, 0.5 * size.width, 0, used, 0.5 * size.height, 0, 0, 1;
  return lens;
}

std::array<bool, 4> tilts_of(const std::vector<BoardView>& taken, const CalibrationBoard& board,
                             Size camera) {
  const double least = std::sin(12 * std::numbers::pi / 180);
  std::array<bool, 4> tilted{};
  if (taken.empty()) return tilted;
  const std::vector<Eigen::Vector3d> printed = printed_places(board);
  const Lens lens = lens_by(taken, printed, camera);
  for (const BoardView& view : taken) {
    // How much farther the board's right and its lower edge are.
    const Eigen::Matrix3d turn = pose_before_camera(view, lens, printed).linear();
    tilted[0] |= turn(2, 0) > least;
    tilted[1] |= turn(2, 0) < -least;
    tilted[2] |= turn(2, 1) > least;
    tilted[3] |= turn(2, 1) < -least;
  }
  return tilted;
}

/// Whether boards cover half of a cell.
bool is_seen_in(const Image<std::uint8_t>& coverage, int row, int column) {
  constexpr int cells = PoseNeeds::cells;
  const int left = column * coverage.width() / cells,
            right = (column + 1) * coverage.width() / cells;
  const int top = row * coverage.height() / cells, bottom = (row + 1) * coverage.height() / cells;
  int covered = 0;
  for (int y = top; y < bottom; ++y) {
    for (int x = left; x < right; ++x) covered += coverage(x, y) > 0 ? 1 : 0;
  }
  return 2 * covered >= (right - left) * (bottom - top);
}

/// The places of the picture where no board was, as a person calls them.
std::vector<std::string> missing_places(const PoseNeeds& needs) {
  constexpr std::array rows{"top", "middle", "bottom"}, columns{"left", "middle", "right"};
  std::vector<std::string> places;
  for (std::size_t row = 0; row < rows.size(); ++row) {
    for (std::size_t column = 0; column < columns.size(); ++column) {
      if (needs.seen_in[row][column]) continue;
      places.push_back(row == 1 && column == 1 ? "middle"
                                               : fmt::format("{} {}", rows[row], columns[column]));
    }
  }
  return places;
}

/// `turn`: which of several places is named; not all of them may be in the projector's light.
std::string advice_for(const PoseNeeds& needs, std::size_t turn) {
  constexpr std::array edges{"left", "right", "upper", "lower"};
  std::vector<std::string> advice;
  const auto edge = std::find(needs.tilted.begin(), needs.tilted.end(), false);
  if (edge != needs.tilted.end()) {
    advice.push_back(fmt::format("tilt its {} edge towards the camera by 20 to 40 degrees",
                                 edges[static_cast<std::size_t>(edge - needs.tilted.begin())]));
  }
  const std::vector<std::string> places = missing_places(needs);
  if (!places.empty()) {
    advice.push_back(
        fmt::format("hold it towards the {} of the picture", places[turn % places.size()]));
  }
  if (advice.empty()) advice.emplace_back("hold it another way, nearer or farther");
  return fmt::format("{}", fmt::join(advice, ", and "));
}

}  // namespace

PoseVerdict judge_pose(const FringeFreePictures& pictures, bool still,
                       const CalibrationBoard& board, const std::vector<BoardView>& taken) {
  std::optional<BoardCorners> seen;
  try {
    seen = find_board(board, pictures);
  } catch (const Error& error) {
    return {PoseState::unseen, error.what()};
  }
  if (!seen) {
    return {PoseState::unseen,
            fmt::format("no {} of {}x{} corners is seen{}", name_of(board.kind), board.columns,
                        board.rows, board.kind == BoardKind::charuco ? "" : " whole")};
  }
  if (std::optional<PoseVerdict> why = unfit(pictures, board, *seen)) return *why;
  if (const BoardView* const known = same_pose(*seen, taken, pictures.mean.width())) {
    return {PoseState::known, fmt::format("this pose is taken ({}): another one", known->name),
            std::move(seen)};
  }
  if (!still) return {PoseState::moving, "hold still", std::move(seen)};
  return {PoseState::good, "good: it is being taken, hold still", std::move(seen)};
}

PoseNeeds pose_needs(const std::vector<BoardView>& taken, const CalibrationBoard& board,
                     Size camera, int wanted) {
  constexpr std::size_t few = 10, many = 20;
  constexpr double well_covered = 0.6;
  PoseNeeds needs{.coverage = coverage_map(taken, Device::camera, camera)};
  needs.covered = covered_share(needs.coverage);
  for (int row = 0; row < PoseNeeds::cells; ++row) {
    for (int column = 0; column < PoseNeeds::cells; ++column) {
      needs.seen_in[static_cast<std::size_t>(row)][static_cast<std::size_t>(column)] =
          is_seen_in(needs.coverage, row, column);
    }
  }
  needs.tilted = tilts_of(taken, board, camera);
  const bool all_ways =
      std::find(needs.tilted.begin(), needs.tilted.end(), false) == needs.tilted.end();
  needs.enough = wanted > 0 ? taken.size() >= static_cast<std::size_t>(wanted)
                            : taken.size() >= many || (taken.size() >= few && all_ways &&
                                                       needs.covered >= well_covered);
  if (!needs.enough) needs.advice = advice_for(needs, taken.size());
  return needs;
}

}  // namespace slipstream
