#include "slipstream/geometry_calibration.h"

#include <cmath>
#include <ostream>
#include <string>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "base/numbers.h"
#include "calibrate/board_view.h"
#include "calibrate/left_out.h"
#include "slipstream/board_capture.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/calibrate/virtual_views.h"
#include "tests/io/expect_error.h"

namespace slipstream {

void PrintTo(const CalibrationBoard& board, std::ostream* out) {
  *out << name_of(board.kind);
}

namespace {

double angle_between(const Scanner& a, const Scanner& b) {
  return Eigen::AngleAxisd(a.rotation.transpose() * b.rotation).angle();
}

/// Simulates a scan of a board along one axis.
Scan scan_of(const Scanner& scanner, const Body& sheet, const Strategy& strategy, Axis axis,
             std::uint64_t seed) {
  const Sequence sequence{.strategy = strategy, .axis = axis, .projector = scanner.projector.size};
  return {.frames = take_scan(scanner, {sheet}, pattern_set(sequence),
                              {.ambient = 5, .noise_variance = 1.55, .bits = 8, .seed = seed})
                        .frames,
          .sequence = sequence};
}

/// Calibrates from frames of `count` poses in front of `truth`, with the program's defaults.
GeometryCalibration calibrated_from_frames(const CalibrationBoard& board, const Scanner& truth,
                                           int count) {
  const Strategy strategy = DualFrequency{.steps = 4, .high = 16, .low = 1};
  constexpr int pixels_per_spacing = 100;
  Body sheet = printed_sheet(draw_board(board, pixels_per_spacing),
                             board.spacing / pixels_per_spacing, truth);
  const auto& [width, height] = std::get<Board>(sheet.shape);
  std::vector<BoardView> views;
  for (const Eigen::Isometry3d& pose : board_poses(truth, count, width, height)) {
    sheet.pose = pose;
    const std::string name = "pose" + std::to_string(views.size());
    const std::uint64_t seed = 2 * views.size() + 1;
    const BoardCapture capture =
        board_capture(name, board, scan_of(truth, sheet, strategy, Axis::x, seed),
                      scan_of(truth, sheet, strategy, Axis::y, seed + 1));
    EXPECT_TRUE(capture.view) << name << ": " << capture.message;
    if (capture.view) views.push_back(*capture.view);
  }
  return calibrate_geometry(views, board, truth.camera.size, truth.projector.size);
}

/// `tolerance` 1: focal lengths and baseline within 0.1 %, principal points within 1 px, rotation
/// within 0.02 degrees.
void expect_near(const Scanner& scanner, const Scanner& truth, double tolerance) {
  for (const auto& [lens, true_lens] :
       {std::pair(scanner.camera, truth.camera), std::pair(scanner.projector, truth.projector)}) {
    const Eigen::Matrix3d& K = lens.intrinsic;
    const Eigen::Matrix3d& true_K = true_lens.intrinsic;
    EXPECT_NEAR(K(0, 0), true_K(0, 0), tolerance * 1e-3 * true_K(0, 0));
    EXPECT_NEAR(K(1, 1), true_K(1, 1), tolerance * 1e-3 * true_K(1, 1));
    EXPECT_NEAR(K(0, 2), true_K(0, 2), tolerance);
    EXPECT_NEAR(K(1, 2), true_K(1, 2), tolerance);
  }
  EXPECT_NEAR(scanner.translation.norm(), truth.translation.norm(),
              tolerance * 1e-3 * truth.translation.norm());
  EXPECT_LT(angle_between(scanner, truth), tolerance * 0.02 * degree);
}

class GeometryCalibrationFromFrames : public testing::TestWithParam<CalibrationBoard> {};

// The sanitized build uses fewer poses, a coarser camera and a looser tolerance, for speed.
TEST_P(GeometryCalibrationFromFrames, IsTheTrueScanner) {
#ifdef __SANITIZE_ADDRESS__
  constexpr int count = 6;
  constexpr double tolerance = 10;
  const Scanner truth = example_scanner({320, 240});
  if (GetParam().kind != BoardKind::chessboard) GTEST_SKIP() << "too slow under the sanitizers";
#else
  constexpr int count = 12;
  constexpr double tolerance = 1;
  const Scanner truth = example_scanner({640, 480});
#endif
  const GeometryCalibration found = calibrated_from_frames(GetParam(), truth, count);
  expect_near(found.state.scanner, truth, tolerance);
  EXPECT_LT(found.rms.camera, 0.15);
  EXPECT_LT(found.rms.projector, 0.25);
}

INSTANTIATE_TEST_SUITE_P(
    Boards, GeometryCalibrationFromFrames,
    testing::Values(
        CalibrationBoard{.columns = 13, .rows = 9, .spacing = 15},
        CalibrationBoard{.kind = BoardKind::circles, .columns = 6, .rows = 9, .spacing = 15},
        CalibrationBoard{.kind = BoardKind::charuco, .columns = 9, .rows = 6, .spacing = 20},
        CalibrationBoard{
            .kind = BoardKind::symmetric_circles, .columns = 9, .rows = 7, .spacing = 15}),
    [](const auto& board) {
      std::string name(name_of(board.param.kind));
      std::ranges::replace(name, '-', '_');
      return name;
    });

TEST(GeometryCalibration, BoardCaptureRefusesWhatGivesNoCoordinateAndSettingsOutOfRange) {
  const auto capture = [](const Strategy& strategy, const BoardCaptureSettings& settings = {}) {
    const Size projector{1280, 800};
    const Scan x{.sequence = {.strategy = strategy, .axis = Axis::x, .projector = projector}};
    const Scan y{.sequence = {.strategy = strategy, .axis = Axis::y, .projector = projector}};
    (void)board_capture("pose", {}, x, y, settings);
  };
  expect_error([&] { capture(PhaseMeasuring{.steps = 4, .frequency = 8}); },
               {"pmp", "no projector coordinate"});
  expect_error([&] { capture(PhaseChannelMultiplexing{.steps = 3}); },
               {"pcmp of 3 steps", "ambient light", "dual-frequency"});
  const double nan = std::nan("");
  for (const double value : {nan, -1.0, 256.0}) {
    expect_error([&] { capture(DualFrequency{}, {.minimum_modulation = value}); },
                 {"least modulation", "0 to 255"});
  }
  for (const double value : {nan, 0.0, -1.0, 11.0}) {
    expect_error([&] { capture(DualFrequency{}, {.neighbourhood = value}); },
                 {"neighbourhood", "at most 10"});
  }
}

TEST(GeometryCalibration, BoardCaptureRefusesScansOfTwoProjectorsOrOfNoneThatIsKnown) {
  const auto along = [](Axis axis, Size projector) {
    return Scan{.sequence = {.strategy = DualFrequency{}, .axis = axis, .projector = projector}};
  };
  expect_error(
      [&] {
        (void)board_capture("pose", {}, along(Axis::x, {1280, 800}), along(Axis::y, {1024, 768}));
      },
      {"1280x800", "1024x768"});
  expect_error([&] { (void)board_capture("pose", {}, along(Axis::x, {}), along(Axis::y, {})); },
               {"projectors", "known"});
}

class GeometryCalibrationOfCorners : public testing::Test {
 protected:
  const CalibrationBoard board{.columns = 7, .rows = 5, .spacing = 20};
  const Scanner truth = example_scanner();
  const GeometryCalibrationSettings plain{.camera_coefficients = 2, .projector_coefficients = 2};

  VirtualViews boards(int count, double noise = 0.05) const {
    return virtual_views(truth, board, printed_places(board), count, noise);
  }
  GeometryCalibration calibrated(const std::vector<BoardView>& views,
                                 const GeometryCalibrationSettings& settings) const {
    return calibrate_geometry(views, board, truth.camera.size, truth.projector.size, settings);
  }
};

// By chance four coefficients predict the corners of these poses best.
TEST_F(GeometryCalibrationOfCorners, ChoosesNoMoreCoefficientsThanThereAre) {
  Scanner straight = truth;
  straight.camera.distortion = {};
  const auto views = virtual_views(straight, board, printed_places(board), 6, 0.05, 5).views;
  const GeometryCalibration found = calibrated(views, {});
  EXPECT_LE(found.camera_lens.coefficients, 1);
  EXPECT_GE(found.projector_lens.coefficients, 1);
  EXPECT_GE(found.camera_lens.scores.size(), 3U);
  const auto& k = found.state.scanner.camera.distortion.coefficients;
  EXPECT_EQ(k[4], 0);
}

TEST_F(GeometryCalibrationOfCorners, KnowsTheDepthsAndTheLargestTiltOfTheBoards) {
  const VirtualViews seen = boards(6);
  double nearest = 1e9, farthest = 0, tilt = 0;
  for (const Eigen::Isometry3d& pose : seen.poses) {
    for (const Eigen::Vector3d& place : printed_places(board)) {
      nearest = std::min(nearest, (pose * place).z());
      farthest = std::max(farthest, (pose * place).z());
    }
    for (const Eigen::Isometry3d& other : seen.poses) {
      tilt =
          std::max(tilt, std::acos(std::min(1.0, pose.linear().col(2).dot(other.linear().col(2)))));
    }
  }

  const GeometryCalibration found = calibrated(seen.views, plain);
  EXPECT_NEAR(found.largest_tilt, tilt, 0.5 * degree);
  const auto& depths = found.state.scanner.calibrated_depths;
  ASSERT_TRUE(depths);
  EXPECT_NEAR(depths->nearest, nearest, 2);
  EXPECT_NEAR(depths->farthest, farthest, 2);

  // A pose that fits as well as the others adds one to their sum.
  double misfit = 0;
  for (const CalibratedPose& pose : found.poses) misfit += pose.misfit / 6;
  EXPECT_NEAR(misfit, 1, 0.5);
}

TEST_F(GeometryCalibrationOfCorners, MeasuresHowMuchHigherThePrintIs) {
  BoardPlaces places = printed_places(board);
  for (Eigen::Vector3d& place : places) place.y() *= 1.01;
  const auto views = virtual_views(truth, board, places, 6, 0.05).views;
  EXPECT_NEAR(calibrated(views, plain).print.stretch, 0.01, 0.002);
}

// The standard errors of the mean are 0.02 and 0.2.
TEST(GeometryCalibration, AModelIsClearlyWorseBeyondTheScatterOfItsFolds) {
  const std::vector<double> best(4, 1.0);
  EXPECT_TRUE(clearly_worse({1.06, 1.14, 1.06, 1.14}, best));
  EXPECT_FALSE(clearly_worse({0.75, 1.45, 0.75, 1.45}, best));
}

TEST_F(GeometryCalibrationOfCorners, TellsFewPosesAndParallelBoards) {
  const auto warned = [](const GeometryCalibration& calibration, const std::string& words) {
    for (const Finding& finding : calibration.findings) {
      if (text_of(finding).find(words) != std::string::npos) return true;
    }
    return false;
  };
  const GeometryCalibration three = calibrated(boards(3).views, plain);
  EXPECT_TRUE(warned(three, "only 3 poses"));
  EXPECT_FALSE(warned(three, "parallel"));

  std::vector<BoardView> parallel;
  const VirtualViews tilted = boards(6, 0);
  for (const double turn : {0.0, 0.03, 0.06, 0.09, 0.12, 0.15}) {
    BoardView view = tilted.views[0];
    Eigen::Isometry3d pose = tilted.poses[0];
    pose.rotate(Eigen::AngleAxisd(turn, Eigen::Vector3d::UnitX()));
    pose.pretranslate(Eigen::Vector3d(0, 0, 100 * turn));
    const auto places = printed_places(board);
    for (std::size_t i = 0; i < places.size(); ++i) {
      view.camera[i] = project(truth.camera, pose * places[i]);
      view.projector[i] = project(truth.projector, in_projector_frame(truth, pose * places[i]));
    }
    parallel.push_back(view);
  }
  EXPECT_TRUE(warned(calibrated(parallel, plain), "nearly parallel"));
}

TEST_F(GeometryCalibrationOfCorners, WithTooFewPosesIsAnError) {
  expect_error([&] { (void)calibrated(boards(2).views, plain); }, {"2 usable poses", "at least 3"});
  expect_error([&] { (void)calibrated(boards(3).views, {.camera_coefficients = 3}); },
               {"3 distortion coefficients", "0, 1, 2, 4, 5, 8, 12"});
}

TEST_F(GeometryCalibrationOfCorners, MirroredAndSwappedAxesAreTold) {
  const auto changed = [&](const auto& change) {
    std::vector<BoardView> views = boards(4).views;
    for (BoardView& view : views) {
      for (Eigen::Vector2d& pixel : view.projector) pixel = change(pixel);
    }
    return views;
  };
  using Pixel = Eigen::Vector2d;
  expect_error(
      [&] { (void)calibrated(changed([](Pixel p) { return Pixel(1279 - p.x(), p.y()); }), plain); },
      {"pose0", "mirrored along x"});
  expect_error(
      [&] { (void)calibrated(changed([](Pixel p) { return Pixel(p.x(), 799 - p.y()); }), plain); },
      {"pose0", "mirrored along y"});
  expect_error(
      [&] { (void)calibrated(changed([](Pixel p) { return Pixel(p.y(), p.x()); }), plain); },
      {"pose0", "swapped", "`first_axis`"});
  // A projector mounted upside down is valid.
  EXPECT_NO_THROW(
      (void)calibrated(changed([](Pixel p) { return Pixel(1279 - p.x(), 799 - p.y()); }), plain));
}

TEST_F(GeometryCalibrationOfCorners, APoseWithFewLitCornersIsNotToldAsMirrored) {
  for (const std::size_t lit : {0U, 2U}) {
    std::vector<BoardView> views = boards(4).views;
    for (std::size_t i = lit; i < views[2].projector.size(); ++i) {
      views[2].projector[i] = {std::nan(""), std::nan("")};
    }
    expect_error([&] { (void)calibrated(views, plain); },
                 {"pose2", "fewer than 4 corners", "`excluded`"});
  }
}

TEST_F(GeometryCalibrationOfCorners, PosesOfAnotherCameraAreTold) {
  Scanner other = truth;
  other.camera.intrinsic(0, 0) = other.camera.intrinsic(1, 1) = 1000;
  other.translation.x() += 20;
  const auto views_of_other = virtual_views(other, board, printed_places(board), 6, 0.05).views;
  std::vector<BoardView> one = boards(6).views;
  one[4] = views_of_other[4];
  expect_error([&] { (void)calibrated(one, plain); }, {"pose4", "do not fit", "`excluded pose4`"});
  std::vector<BoardView> half = boards(6).views;
  for (const std::size_t v : {1U, 3U, 5U}) half[v] = views_of_other[v];
  expect_error([&] { (void)calibrated(half, plain); }, {"fit"});
}

TEST_F(GeometryCalibrationOfCorners, CornersOffByAFringeAreLeftOut) {
  std::vector<BoardView> views = boards(5).views;
  views[1].projector[3].x() += 80;
  views[1].projector[12].y() -= 50;
  const GeometryCalibration found = calibrated(views, plain);
  EXPECT_EQ(found.poses[1].lit, 33);
  EXPECT_EQ(lit_corners(found.views[1]), 33);
  EXPECT_LT(found.rms.projector, 0.1);
}

}  // namespace
}  // namespace slipstream
