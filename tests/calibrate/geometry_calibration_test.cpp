#include "slipstream/calibrate/geometry_calibration.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "slipstream/simulate/named_scenes.h"
#include "tests/calibrate/virtual_views.h"
#include "tests/io/expect_error.h"

namespace slipstream {
namespace {

class CalibrationOfCorners : public testing::Test {
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

TEST_F(CalibrationOfCorners, ChoosesNoMoreCoefficientsThanThereAre) {
  Scanner straight = truth;
  straight.camera.distortion = {};
  const auto views = virtual_views(straight, board, printed_places(board), 6, 0.05).views;
  const GeometryCalibration found = calibrated(views, {});
  EXPECT_LE(found.camera_lens.coefficients, 1);
  EXPECT_GE(found.projector_lens.coefficients, 1);
  EXPECT_EQ(found.camera_lens.scores.size(), lens_models.size());
  const auto& k = found.state.scanner.camera.distortion.coefficients;
  EXPECT_EQ(k[4], 0);
}

TEST_F(CalibrationOfCorners, TellsFewPosesAndParallelBoards) {
  const auto warned = [](const GeometryCalibration& calibration, const std::string& words) {
    for (const std::string& warning : calibration.warnings) {
      if (warning.find(words) != std::string::npos) return true;
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

TEST_F(CalibrationOfCorners, WithTooFewPosesIsAnError) {
  expect_error([&] { (void)calibrated(boards(2).views, plain); }, {"2 usable poses", "at least 3"});
  expect_error([&] { (void)calibrated(boards(3).views, {.camera_coefficients = 3}); },
               {"3 distortion coefficients", "0, 1, 2, 4, 5, 8, 12"});
}

TEST_F(CalibrationOfCorners, MirroredAndSwappedAxesAreTold) {
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
      {"pose0", "swapped", "--first-axis"});
  // A device that is turned is no mistake.
  EXPECT_NO_THROW(
      (void)calibrated(changed([](Pixel p) { return Pixel(1279 - p.x(), 799 - p.y()); }), plain));
}

TEST_F(CalibrationOfCorners, PosesOfAnotherCameraAreTold) {
  Scanner other = truth;
  other.camera.intrinsic(0, 0) = other.camera.intrinsic(1, 1) = 1000;
  other.translation.x() += 20;
  const auto views_of_other = virtual_views(other, board, printed_places(board), 6, 0.05).views;
  std::vector<BoardView> one = boards(6).views;
  one[4] = views_of_other[4];
  expect_error([&] { (void)calibrated(one, plain); }, {"pose4", "do not fit", "--exclude"});
  std::vector<BoardView> half = boards(6).views;
  for (const std::size_t v : {1U, 3U, 5U}) half[v] = views_of_other[v];
  expect_error([&] { (void)calibrated(half, plain); }, {"fit"});
}

TEST_F(CalibrationOfCorners, CornersOffByAFringeAreLeftOut) {
  std::vector<BoardView> views = boards(5).views;
  views[1].projector[3].x() += 80;
  views[1].projector[12].y() -= 50;
  const GeometryCalibration found = calibrated(views, plain);
  EXPECT_EQ(found.poses[1].lit, 33);
  EXPECT_LT(found.rms.projector, 0.1);
}

}  // namespace
}  // namespace slipstream
