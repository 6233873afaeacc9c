#include "calibrate/pose_guide.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>
#include <numbers>
#include <optional>
#include <string>
#include <vector>

#include <opencv2/calib3d.hpp>

#include "base/statistics.h"
#include "base/throw_if-inl.h"
#include "calibrate/board_corners.h"
#include "calibrate/board_view.h"
#include "calibrate/first_guess.h"
#include "calibrate/opencv.h"

namespace slipstream {
namespace fs = std::filesystem;
namespace {

/// Grey levels of the board's pixels, all within the hull of its corners.
std::vector<float> greys_of(const Image<float>& picture, const BoardCorners& board) {
  std::vector<cv::Point> corners;
  std::ranges::transform(board.pixels, std::back_inserter(corners), nearest_pixel);
  const cv::Mat inside = within_hull(corners, {picture.width(), picture.height()});

  std::vector<float> greys;
  for_each_pixel_in_order(picture.size(), [&](int column, int row) {
    if (inside.at<std::uint8_t>(row, column) != 0) greys.push_back(picture(column, row));
  });
  return greys;
}

/// Mean distance of the common corners, pixels; infinite without common corners.
double distance(const BoardCorners& seen, const BoardView& taken) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < seen.places.size(); ++i) {
    const auto before = std::ranges::find(taken.places, seen.places[i]);
    if (before == taken.places.end()) continue;
    sum += (seen.pixels[i] - taken.camera[before - taken.places.begin()]).norm();
    ++count;
  }

  return count > 0 ? sum / count : std::numeric_limits<double>::infinity();
}

/// Verdict on exposure and focus; nullopt if both are fine.
std::optional<PoseVerdict> unfit(const FringeFreePictures& pictures, const CalibrationBoard& board,
                                 const BoardCorners& seen) {
  // Half a grey level below 255, for rounding when other depths are scaled to 8 bits.
  constexpr float full_scale = 254.5F;
  constexpr double most_saturated = 0.25, least_white = 40;
  const auto verdict = [&](PoseState state, std::string words) {
    return PoseVerdict{state, std::move(words), seen};
  };

  // 1. Exposure.
  std::vector<float> greys = greys_of(pictures.brightest, seen);
  if (greys.empty()) return verdict(PoseState::unseen, "the board is too small");

  const auto saturated =
      std::count_if(greys.begin(), greys.end(), [](float grey) { return grey >= full_scale; });
  const double share = static_cast<double>(saturated) / static_cast<double>(greys.size());

  if (share >= most_saturated) {
    return verdict(
        PoseState::overexposed,
        fmt::format("{:.0f} % of the board is saturated: shorten the exposure, stop down or dim "
                    "the projector",
                    100 * share));
  }

  // The brightest tenth of the board's pixels is white paper.
  const double white = quantile(greys, 0.9);
  if (white < least_white) {
    return verdict(
        PoseState::dark,
        fmt::format("the board's white is {:.0f} of 255 grey levels (limit {:g}): lengthen "
                    "the exposure, open the iris or move it into the projector's light",
                    white, least_white));
  }

  // 2. Focus.
  const EdgeSoftness edges = edge_softness(pictures.mean, board, seen.places, seen.pixels);
  if (is_soft(edges)) {
    return verdict(PoseState::blurred,
                   fmt::format("edges are {:.1f} pixels wide: focus the camera on the board, or "
                               "hold it still",
                               edges.pixels));
  }

  return std::nullopt;
}

std::array<bool, 4> tilts_of(const BoardViews& taken, const CalibrationBoard& board, Size camera) {
  // The sine of 12 degrees.
  const double least = std::sin(12 * std::numbers::pi / 180);
  std::array<bool, 4> tilted{};
  if (taken.empty()) return tilted;

  const BoardPlaces printed = printed_places(board);
  const Lens lens = simple_lens(taken, printed, camera);

  for (const BoardView& view : taken) {
    // How much farther away the board's right and lower edges are.
    const Eigen::Matrix3d turn = pose_before_camera(view, lens, printed).linear();
    tilted[0] |= turn(2, 0) > least;
    tilted[1] |= turn(2, 0) < -least;
    tilted[2] |= turn(2, 1) > least;
    tilted[3] |= turn(2, 1) < -least;
  }

  return tilted;
}

/// Names of the parts of the picture that boards cover less than half.
std::vector<std::string> missing_places(const Image<std::uint8_t>& coverage) {
  constexpr std::array rows{"top", "middle", "bottom"}, columns{"left", "middle", "right"};

  // Corners of the ninths of the coverage map.
  const auto corner = [&](int across, int down) {
    return cv::Point(across * coverage.width() / 3, down * coverage.height() / 3);
  };

  std::vector<std::string> places;
  for_each_pixel_in_order({3, 3}, [&](int column, int row) {
    const cv::Rect part(corner(column, row), corner(column + 1, row + 1));
    if (2 * cv::countNonZero(mat_of(coverage)(part)) >= part.area()) return;

    const bool is_middle = column == 1 && row == 1;
    places.push_back(is_middle ? "middle" : fmt::format("{} {}", rows[row], columns[column]));
  });

  return places;
}

/// `turn`: selects one of several places, since some may be outside the projector's light.
std::string advice_for(const PoseNeeds& needs, std::size_t turn) {
  constexpr std::array edges{"left", "right", "upper", "lower"};
  std::vector<std::string> advice;

  const auto edge = std::ranges::find(needs.tilted, false);
  if (edge != needs.tilted.end()) {
    advice.push_back(fmt::format("tilt its {} edge towards the camera by 20 to 40 degrees",
                                 edges[edge - needs.tilted.begin()]));
  }

  const std::vector<std::string> places = missing_places(needs.coverage);
  if (!places.empty()) {
    advice.push_back(
        fmt::format("hold it towards the {} of the picture", places[turn % places.size()]));
  }
  if (advice.empty()) advice.emplace_back("change its tilt or its distance");

  return fmt::format("{}", fmt::join(advice, ", and "));
}

constexpr Colour green{90, 220, 110}, yellow{250, 210, 60}, red{255, 95, 80}, orange{255, 150, 50};

cv::Scalar scalar_of(Colour colour) {
  return {static_cast<double>(colour.red), static_cast<double>(colour.green),
          static_cast<double>(colour.blue)};
}

/// The drawing, with `scale` pixels per camera pixel.
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

void draw_outline(const Drawing& drawing, const PixelPlaces& corners, const cv::Scalar& colour) {
  std::vector<cv::Point> places, hull;
  for (const Eigen::Vector2d& corner : corners) places.push_back(drawing.place(corner));
  if (places.empty()) return;

  cv::convexHull(places, hull);
  cv::polylines(drawing.picture, hull, true, colour, drawing.line, cv::LINE_AA);
}

/// Draws an outward arrow at the middle of each side of the picture.
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

struct GuidedPoses {
  ScanCamera& camera;
  const fs::path& folder;
  const CalibrationBoard& board;
  const Sequence& sequence;
  const GuidedPosesSettings& settings;
  BoardViews taken{};
  std::optional<PoseVerdict> refused{};  ///< the rejected pose, until the board moves
  bool enough = false;

  BoardViews take_all() {
    while (!enough && !(settings.ends && settings.ends())) {
      if (const auto glimpse = camera.look(std::chrono::milliseconds(200))) judge(*glimpse);
    }
    return std::move(taken);
  }

  void judge(const Glimpse& glimpse) {
    const FringeFreePictures pictures =
        fringe_free_pictures(glimpse.frames.front(), glimpse.frames.back());
    PoseVerdict verdict = judge_pose(pictures, glimpse.still, board, taken);

    // A refused pose is not tried again before the board has moved.
    if (!glimpse.still) refused.reset();
    if (verdict.state == PoseState::good && refused) verdict = *refused;

    tell(pictures, verdict);
    if (verdict.state != PoseState::good) return;

    std::optional<std::vector<FrameSet>> frames = camera.take();
    verdict = frames ? keep(std::move(*frames), verdict)
                     : PoseVerdict{PoseState::moving, "the board moved during capture: hold still",
                                   verdict.board};

    if (verdict.state == PoseState::refused) refused = verdict;
    tell(pictures, verdict);
  }

  /// Writes the scans of a pose if they are usable.
  PoseVerdict keep(std::vector<FrameSet> frames, const PoseVerdict& seen) {
    const std::string name = fmt::format("board{:02}", taken.size() + 1);

    std::vector<Scan> scans;
    for (const Axis axis : {Axis::x, Axis::y}) {
      scans.push_back(
          {.frames = std::move(frames.at(scans.size())), .sequence = along(sequence, axis)});
      scans.back().sequence.marker = false;  // the frames contain no marker
    }

    BoardCapture found = board_capture(name, board, scans[0], scans[1]);
    if (!found.view) return {PoseState::refused, "refused: " + found.message, seen.board};

    for (const Scan& scan : scans) settings.save(folder / name / name_of(scan.sequence.axis), scan);
    taken.push_back(std::move(*found.view));
    return {PoseState::taken, fmt::format("{} captured: {}", name, found.message), seen.board};
  }

  void tell(const FringeFreePictures& pictures, const PoseVerdict& verdict) {
    const PoseNeeds needs = pose_needs(taken, board, pictures.mean.size(), settings.wanted);
    enough = needs.enough;
    if (settings.on_progress) settings.on_progress({pictures, verdict, needs, taken});
  }
};

}  // namespace

PoseVerdict judge_pose(const FringeFreePictures& pictures, bool still,
                       const CalibrationBoard& board, const BoardViews& taken) {
  std::optional<BoardCorners> seen;
  try {
    seen = find_board(board, pictures);
  } catch (const Error& error) {
    return {PoseState::unseen, error.what()};
  }

  if (!seen) {
    return {PoseState::unseen,
            fmt::format("no {} of {}x{} corners is {}visible", name_of(board.kind), board.columns,
                        board.rows, board.kind == BoardKind::charuco ? "" : "fully ")};
  }

  if (std::optional<PoseVerdict> why = unfit(pictures, board, *seen)) return *why;

  constexpr double near = 0.03;  // of the picture's width
  const auto known = std::ranges::find_if(taken, [&](const BoardView& view) {
    return distance(*seen, view) < near * pictures.mean.width();
  });
  if (known != taken.end()) {
    return {PoseState::known,
            fmt::format("pose already captured ({}): move or tilt the board", known->name),
            std::move(seen)};
  }

  if (!still) return {PoseState::moving, "hold still", std::move(seen)};
  return {PoseState::good, "good: capturing, hold still", std::move(seen)};
}

PoseNeeds pose_needs(const BoardViews& taken, const CalibrationBoard& board, Size camera,
                     int wanted) {
  constexpr std::size_t few = 10, many = 20;
  constexpr double well_covered = 0.6;

  PoseNeeds needs{.coverage = coverage_map(taken, Device::camera, camera)};
  needs.covered = covered_share(needs.coverage);
  needs.tilted = tilts_of(taken, board, camera);
  const bool all_ways = std::ranges::count(needs.tilted, false) == 0;

  // Without a wanted number: twenty, or ten that include every tilt and cover the picture.
  needs.enough = wanted > 0 ? std::cmp_greater_equal(taken.size(), wanted)
                            : taken.size() >= many || (taken.size() >= few && all_ways &&
                                                       needs.covered >= well_covered);

  if (!needs.enough) needs.advice = advice_for(needs, taken.size());
  return needs;
}

Colour colour_of(PoseState state) {
  if (state == PoseState::good || state == PoseState::taken) return green;
  return state == PoseState::moving || state == PoseState::known ? yellow : red;
}

Image<Colour> drawn_guide(const Image<float>& picture, const PoseVerdict& verdict,
                          const PoseNeeds& needs, const BoardViews& taken, int width) {
  const Drawing drawing = enlarged(picture, width);
  if (!needs.enough) dim_uncovered(drawing, needs.coverage);
  for (const BoardView& view : taken) draw_outline(drawing, view.camera, scalar_of(green) * 0.7);

  if (verdict.board) {
    const cv::Scalar colour = scalar_of(colour_of(verdict.state));
    draw_outline(drawing, verdict.board->pixels, colour);
    for (const Eigen::Vector2d& corner : verdict.board->pixels) {
      cv::circle(drawing.picture, drawing.place(corner), 2 * drawing.line, colour, -1, cv::LINE_AA);
    }
  }

  draw_tilts(drawing, needs.tilted);
  return image_from<Colour>(drawing.picture);
}

BoardViews take_guided_poses(ScanCamera& camera, const fs::path& folder,
                             const CalibrationBoard& board, const Sequence& sequence,
                             const GuidedPosesSettings& settings) {
  throw_if(fs::exists(folder) && !fs::is_empty(folder),
           "{}: not empty; name a new folder for the poses", folder.string());
  return GuidedPoses{camera, folder, board, sequence, settings}.take_all();
}

}  // namespace slipstream
