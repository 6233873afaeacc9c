#include "calibrate/board_corners.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>
#include <optional>
#include <vector>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <opencv2/calib3d.hpp>
#include <opencv2/features2d.hpp>

#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "calibrate/charuco.h"
#include "calibrate/opencv.h"

namespace slipstream {
namespace {

using Corners = std::vector<cv::Point2f>;

/// Adds frames to mean and maximum.
void add_frames(const FrameViews& frames, FringeFreePictures& pictures, int total) {
  const auto scale = static_cast<float>(255 / frames.full_scale());
  frames.visit([&](const auto& images) {
    for (const auto& image : images) {
      for_each_pixel_in_order(image.size(), [&](int column, int row) {
        const float grey = scale * static_cast<float>(image(column, row));
        pictures.mean(column, row) += grey / static_cast<float>(total);

        float& brightest = pictures.brightest(column, row);
        brightest = std::max(brightest, grey);
      });
    }
  });
}

/// Smallest distance between two corners, pixels.
double least_distance(const Corners& corners) {
  double least = 1e9;
  for (std::size_t i = 0; i < corners.size(); ++i) {
    for (std::size_t j = 0; j < i; ++j) least = std::min(least, cv::norm(corners[i] - corners[j]));
  }
  return least;
}

/// The point near `start` at which the edges within `radius` intersect best (Förstner and Gülch
/// 1987). Uses the pixels without interpolation: the linear one of cv::cornerSubPix pulls corners
/// by up to 0.013 pixels towards pixel borders.
Eigen::Vector2d meeting_of_edges(const cv::Mat& picture, const Eigen::Vector2d& start,
                                 double radius) {
  constexpr int most_rounds = 50;
  constexpr double least_step = 1e-4;  // pixels
  Eigen::Vector2d corner = start, step(radius, radius);

  for (int round = 0; round < most_rounds && step.norm() > least_step; ++round) {
    Eigen::Matrix2d normal = Eigen::Matrix2d::Zero();
    Eigen::Vector2d right = Eigen::Vector2d::Zero();

    // The window, one pixel inside the border, as gradients need the neighbours.
    const Eigen::Array2i first = (corner.array() - radius).ceil().cast<int>().max(1);
    const Eigen::Array2i last = (corner.array() + radius)
                                    .floor()
                                    .cast<int>()
                                    .min(Eigen::Array2i(picture.cols, picture.rows) - 2);

    for (int y = first.y(); y <= last.y(); ++y) {
      for (int x = first.x(); x <= last.x(); ++x) {
        const Eigen::Vector2d offset = Eigen::Vector2d(x, y) - corner;
        const double rest = std::max(0.0, 1 - offset.squaredNorm() / (radius * radius));

        // The edge through a pixel runs across its gradient: gradient . (corner - pixel) = 0.
        const Eigen::Vector2d gradient(picture.at<float>(y, x + 1) - picture.at<float>(y, x - 1),
                                       picture.at<float>(y + 1, x) - picture.at<float>(y - 1, x));
        normal += rest * rest * gradient * gradient.transpose();
        right += rest * rest * gradient.dot(offset) * gradient;
      }
    }

    step = normal.ldlt().solve(right);
    corner += step;

    // The iteration has left the window, or diverged: the detector's corner stays.
    if (!((corner - start).norm() < radius)) return start;
  }

  return corner;
}

/// Refines chessboard corners to subpixel accuracy, in a window that contains only their four
/// squares.
void refine(const cv::Mat& mean, Corners& corners) {
  constexpr double smoothing = 1;      // pixels; 0.7 to 1.4 give the same residuals on real boards
  constexpr double half_square = 0.5;  // of the distance to the next corner

  cv::Mat smooth;
  cv::GaussianBlur(mean, smooth, {}, smoothing);

  // Half a square in pixels, 2 to 12; the round window has the reach of a square one's corner.
  const double radius =
      std::numbers::sqrt2 * std::clamp(half_square * least_distance(corners), 2.0, 12.0);

  for (cv::Point2f& corner : corners) {
    const Eigen::Vector2d found = meeting_of_edges(smooth, {corner.x, corner.y}, radius);
    corner = {static_cast<float>(found.x()), static_cast<float>(found.y())};
  }
}

struct Detection {
  Corners corners;
  std::string detector;
};

std::optional<Detection> find_chessboard(const cv::Size& size, const cv::Mat& mean,
                                         const cv::Mat& brightest) {
  const std::array<std::pair<const char*, cv::Mat>, 2> pictures{
      {{"mean", stretched(mean)}, {"maximum", stretched(brightest)}}};

  constexpr int classic_flags = cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE;
  Detection found;
  for (const int flags : {0, int{cv::CALIB_CB_NORMALIZE_IMAGE}}) {
    for (const auto& [name, picture] : pictures) {
      if (cv::findChessboardCornersSB(picture, size, found.corners, flags)) {
        found.detector = fmt::format("sector-based, {}", name);
        return found;
      }
    }
  }

  for (const auto& [name, picture] : pictures) {
    if (cv::findChessboardCorners(picture, size, found.corners, classic_flags)) {
      found.detector = fmt::format("classic, {}", name);
      return found;
    }
  }

  return std::nullopt;
}

/// `arrangement`: cv::CALIB_CB_ASYMMETRIC_GRID or cv::CALIB_CB_SYMMETRIC_GRID.
std::optional<Detection> find_circles(const cv::Size& size, const cv::Mat& mean,
                                      const cv::Mat& brightest, int arrangement) {
  // Dots of 20 pixels or more, up to a fiftieth of the picture.
  cv::SimpleBlobDetector::Params blobs;
  blobs.minArea = 20;
  blobs.maxArea = static_cast<float>(mean.total()) / 50;
  const cv::Ptr<cv::FeatureDetector> detector = cv::SimpleBlobDetector::create(blobs);

  // Dark circles on white paper, then white ones on a dark board.
  const cv::Mat as_seen = stretched(mean), maximum = stretched(brightest);
  const cv::Mat negative = cv::Scalar::all(255) - as_seen;

  Detection found;
  for (const auto& [name, picture] : {std::pair("mean", as_seen), std::pair("maximum", maximum),
                                      std::pair("negative", negative)}) {
    for (const auto& [method, clustering] :
         {std::pair("grid", 0), std::pair("clustering", int{cv::CALIB_CB_CLUSTERING})}) {
      if (cv::findCirclesGrid(picture, size, found.corners, arrangement | clustering, detector)) {
        found.detector = fmt::format("circles ({}), {}", method, name);
        return found;
      }
    }
  }

  return std::nullopt;
}

/// Orders the corners of a chessboard or symmetric grid from left to right, and from top to bottom
/// for a camera that does not mirror.
void order_as_seen(const CalibrationBoard& board, Corners& corners) {
  const auto at = [&](int column, int row) -> cv::Point2f& {
    return corners[row * board.columns + column];
  };

  // The first row must run to the right.
  if (at(board.columns - 1, 0).x < at(0, 0).x) std::ranges::reverse(corners);

  // Columns must run down: if not, the rows are in reverse order.
  const cv::Point2f along = at(board.columns - 1, 0) - at(0, 0);
  const cv::Point2f down = at(0, board.rows - 1) - at(0, 0);
  if (along.cross(down) > 0) return;

  for (int row = 0; row < board.rows / 2; ++row) {
    std::swap_ranges(&at(0, row), &at(0, row) + board.columns, &at(0, board.rows - 1 - row));
  }
}

/// Whether steps from corner to corner are nearly equal along rows and columns, as in the picture
/// of a board: the detector may join rows of single and of double steps.
bool has_even_steps(const CalibrationBoard& board, const Corners& corners) {
  constexpr double most_uneven = 0.5;  // of two steps
  const auto is_uneven = [&](int i, int step) {
    const cv::Point2f before = corners[i] - corners[i - step];
    const cv::Point2f after = corners[i + step] - corners[i];
    return cv::norm(after - before) > most_uneven * cv::norm(after + before);
  };

  for (int i = 0; i < place_count(board); ++i) {
    const int column = i % board.columns, row = i / board.columns;
    if (column > 0 && column + 1 < board.columns && is_uneven(i, 1)) return false;
    if (row > 0 && row + 1 < board.rows && is_uneven(i, board.columns)) return false;
  }
  return true;
}

/// Contrast of the four squares that meet at `corner`; `along` and `down` lead to the next corners.
/// nullopt outside the picture.
std::optional<double> corner_contrast(const cv::Mat& mean, cv::Point2f corner, cv::Point2f along,
                                      cv::Point2f down) {
  const auto grey = [&](float right, float below) -> std::optional<double> {
    const cv::Point2f at = corner + right * along + below * down;
    const cv::Point pixel(cvRound(at.x), cvRound(at.y));
    if (!cv::Rect({}, mean.size()).contains(pixel)) return std::nullopt;
    return mean.at<float>(pixel);
  };

  constexpr float middle = 0.3F;  // of a square, from the corner
  const auto a = grey(-middle, -middle), b = grey(middle, -middle), c = grey(-middle, middle),
             d = grey(middle, middle);

  if (!a || !b || !c || !d) return std::nullopt;
  return std::abs((*a + *d) - (*b + *c)) / 2;
}

/// Throws Error if the board has corners one row or column further out, or between those found.
/// Beyond the true edge half of the squares are missing, and with them half of the contrast; half
/// way between two corners there is an edge.
void require_whole(const CalibrationBoard& board, const cv::Mat& mean, const Corners& corners) {
  constexpr double share_of_contrast = 0.75;
  constexpr std::size_t fewest_seen = 3;
  const auto at = [&](int column, int row) { return corners[row * board.columns + column]; };

  // Contrast `outwards` places beyond the end of each line of corners; corner_of(i, k) lies k
  // places inside the end of line i.
  const auto contrast = [&](int count, const auto& corner_of, float outwards) {
    std::vector<double> seen;
    for (int i = 0; i + 1 < count; ++i) {
      const cv::Point2f end = corner_of(i, 0), step = end - corner_of(i, 1);
      const auto value =
          corner_contrast(mean, end + outwards * step, step, corner_of(i + 1, 0) - end);
      if (value) seen.push_back(*value);
    }
    return seen;
  };

  const int right = board.columns - 1, bottom = board.rows - 1;
  const auto check = [&](int count, const auto& corner_of) {
    const std::vector<double> inside = contrast(count, corner_of, 0);
    for (const float outwards : {1.0F, -0.5F}) {
      const std::vector<double> further = contrast(count, corner_of, outwards);
      if (inside.size() < fewest_seen || further.size() < fewest_seen) continue;
      throw_if(median(further) >= share_of_contrast * median(inside),
               "the board has more than {}x{} corners; check `corners`", board.columns, board.rows);
    }
  };

  // The left, right, upper and lower side.
  check(board.rows, [&](int i, int inwards) { return at(inwards, i); });
  check(board.rows, [&](int i, int inwards) { return at(right - inwards, i); });
  check(board.columns, [&](int i, int inwards) { return at(i, inwards); });
  check(board.columns, [&](int i, int inwards) { return at(i, bottom - inwards); });
}

BoardCorners board_corners(std::vector<int> places, const Corners& corners, std::string detector) {
  BoardCorners result{std::move(places), {}, std::move(detector)};
  for (const cv::Point2f& corner : corners) result.pixels.emplace_back(corner.x, corner.y);
  return result;
}

/// Centre of the ellipse that a homography makes of a circle around `centre`.
Eigen::Vector2d seen_circle_centre(const Eigen::Matrix3d& homography, const Eigen::Vector2d& centre,
                                   double radius) {
  const Eigen::Vector3d c = centre.homogeneous();
  const Eigen::Matrix3d dual =  // of the circle's conic; a homography H maps it to H dual H^T
      c * c.transpose() - radius * radius * Eigen::Vector3d(1, 1, 0).asDiagonal().toDenseMatrix();

  // The pole of the line at infinity is the conic's centre: the dual conic's last column.
  const Eigen::Matrix3d seen = homography * dual * homography.transpose();
  return seen.col(2).hnormalized();
}

/// Corrects the offset between the centre of a tilted circle's picture and the picture of its
/// centre.
void correct_circle_centres(const CalibrationBoard& board, BoardCorners& found) {
  const BoardPlaces places = printed_places(board);

  std::vector<cv::Point2d> on_board, in_picture;
  for (std::size_t i = 0; i < found.pixels.size(); ++i) {
    const Eigen::Vector3d& place = places[found.places[i]];
    on_board.emplace_back(place.x(), place.y());
    in_picture.emplace_back(found.pixels[i].x(), found.pixels[i].y());
  }

  const cv::Matx33d H = cv::findHomography(on_board, in_picture);
  const Eigen::Matrix3d homography =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(H.val);

  for (std::size_t i = 0; i < found.pixels.size(); ++i) {
    const Eigen::Vector2d centre(on_board[i].x, on_board[i].y);
    const Eigen::Vector2d picture_of_centre = (homography * centre.homogeneous()).hnormalized();
    const double radius = diameter_of(board) * board.spacing / 2;
    found.pixels[i] -= seen_circle_centre(homography, centre, radius) - picture_of_centre;
  }
}

/// Paints markers over with the brightness of their squares, to the middle of their margins, which
/// leaves a plain chessboard.
cv::Mat without_markers(const cv::Mat& mean, const std::vector<Corners>& markers,
                        double marker_side) {
  const auto growth = static_cast<float>((1 + 1 / marker_side) / 2);
  constexpr int samples = 20;  // along each side

  cv::Mat plain = mean.clone();
  for (const Corners& marker : markers) {
    const cv::Point2f middle = (marker[0] + marker[1] + marker[2] + marker[3]) / 4;
    std::vector<cv::Point> outline;
    std::vector<double> margin;

    for (std::size_t side = 0; side < 4; ++side) {
      const cv::Point2f from = middle + growth * (marker[side] - middle);
      const cv::Point2f to = middle + growth * (marker[(side + 1) % 4] - middle);
      outline.emplace_back(from);
      for (int i = 0; i < samples; ++i) {
        const cv::Point pixel(from + static_cast<float>(i) / samples * (to - from));
        if (cv::Rect({}, mean.size()).contains(pixel)) margin.push_back(mean.at<float>(pixel));
      }
    }

    if (!margin.empty()) cv::fillConvexPoly(plain, outline, median(margin));
  }

  return plain;
}

std::optional<BoardCorners> find_charuco(const CalibrationBoard& board, const cv::Mat& mean) {
  constexpr std::size_t fewest_corners = 6;

  // 1. The markers.
  std::vector<Corners> markers;
  std::vector<int> ids, places;
  marker_detector(board).detectMarkers(stretched(mean), markers, ids);

  // 2. The corners between two markers.
  Corners corners;
  for_each_pixel_in_order({board.columns, board.rows}, [&](int column, int row) {
    // The corner lies midway between the two markers beside it.
    const int odd = (column + row) % 2;
    const auto left = std::ranges::find(ids, marker_id(board, column, row + 1 - odd));
    const auto right = std::ranges::find(ids, marker_id(board, column + 1, row + odd));
    if (left == ids.end() || right == ids.end()) return;

    const cv::Point2f of_left = markers[left - ids.begin()][odd ? 2 : 1];
    corners.push_back((of_left + markers[right - ids.begin()][odd ? 0 : 3]) / 2);
    places.push_back(row * board.columns + column);
  });
  if (corners.size() < fewest_corners) return std::nullopt;

  // 3. Refined as on a chessboard.
  refine(without_markers(mean, markers, board.marker_side), corners);
  return board_corners(std::move(places), corners, "ChArUco, mean");
}

}  // namespace

FringeFreePictures fringe_free_pictures(const FrameViews& along_x, const FrameViews& along_y) {
  throw_if(along_x.size() != along_y.size(),
           "the frames along x are {}, along y {}; both must have one size",
           text_of(along_x.size()), text_of(along_y.size()));

  FringeFreePictures pictures{Image<float>(along_x.size()), Image<float>(along_x.size())};
  const int total = along_x.count() + along_y.count();
  add_frames(along_x, pictures, total);
  add_frames(along_y, pictures, total);
  return pictures;
}

std::optional<Size> chessboard_size(const FringeFreePictures& pictures) {
  const QuietOpenCv quiet;

  Corners corners;
  cv::Mat seen;  // a cell for each corner
  for (const Image<float>* picture : {&pictures.mean, &pictures.brightest}) {
    const bool found = cv::findChessboardCornersSB(stretched(mat_of(*picture)), {3, 3}, corners,
                                                   cv::CALIB_CB_LARGER, seen);
    if (found) return Size{std::max(seen.cols, seen.rows), std::min(seen.cols, seen.rows)};
  }

  return std::nullopt;
}

std::optional<BoardCorners> find_board(const CalibrationBoard& board,
                                       const FringeFreePictures& pictures) {
  require_valid(board);
  const QuietOpenCv quiet;
  const cv::Mat mean = mat_of(pictures.mean), brightest = mat_of(pictures.brightest);

  if (board.kind == BoardKind::charuco) return find_charuco(board, mean);
  const cv::Size size(board.columns, board.rows);
  const bool symmetric = board.kind == BoardKind::symmetric_circles;
  std::optional<Detection> found =
      has_circles(board)
          ? find_circles(size, mean, brightest,
                         symmetric ? cv::CALIB_CB_SYMMETRIC_GRID : cv::CALIB_CB_ASYMMETRIC_GRID)
          : find_chessboard(size, mean, brightest);
  if (!found) return std::nullopt;
  if (board.kind == BoardKind::chessboard && !has_even_steps(board, found->corners)) {
    return std::nullopt;
  }

  if (board.kind == BoardKind::chessboard) refine(mean, found->corners);
  if (board.kind != BoardKind::circles) order_as_seen(board, found->corners);
  if (board.kind == BoardKind::chessboard) require_whole(board, mean, found->corners);

  std::vector<int> all(place_count(board));
  std::iota(all.begin(), all.end(), 0);
  BoardCorners corners = board_corners(std::move(all), found->corners, std::move(found->detector));

  if (has_circles(board)) correct_circle_centres(board, corners);
  return corners;
}

}  // namespace slipstream
