// Several cameras of one projector, calibrated one by one and together.
#include "calibrate/several_cameras.h"

#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "calibrate/board_view.h"
#include "calibrate/cameras_adjustment.h"
#include "slipstream/named_scenes.h"
#include "tests/calibrate/virtual_views.h"
#include "tests/io/expect_error.h"

namespace slipstream::several_cameras_test {

const CalibrationBoard board{.columns = 9, .rows = 6, .spacing = 20};

/// The example scanner, and cameras beside it that look at the same place past its projector.
std::vector<Scanner> true_scanners(std::size_t count) {
  const Scanner first = example_scanner();
  std::vector<Scanner> scanners{first};
  for (std::size_t c = 1; c < count; ++c) {
    const double side = c == 1 ? 1 : -1;
    const Eigen::Isometry3d from_first = Eigen::AngleAxisd(0.35 * side, Eigen::Vector3d::UnitY()) *
                                         Eigen::Translation3d(-230 * side, 15, -30);
    const Eigen::Isometry3d rig = rig_of(first) * from_first.inverse();
    Scanner scanner = first;
    scanner.camera.intrinsic(0, 0) *= 1 + 0.01 * static_cast<double>(c);
    scanner.rotation = rig.linear();
    scanner.translation = rig.translation();
    scanners.push_back(scanner);
  }
  return scanners;
}

Eigen::Isometry3d between(const Scanner& first, const Scanner& second) {
  return rig_of(second).inverse() * rig_of(first);
}

/// What each camera sees of the same poses, with noise, and where the board lies in its picture.
std::vector<BoardViews> views_of(const std::vector<Scanner>& scanners, int poses, unsigned seed) {
  const BoardPlaces places = printed_places(board);
  const VirtualViews exact = virtual_views(scanners[0], board, places, poses, 0);
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 0.1);

  std::vector<BoardViews> all;
  for (const Scanner& scanner : scanners) {
    const Eigen::Isometry3d to_camera = between(scanners[0], scanner);
    BoardViews views = exact.views;
    for (std::size_t v = 0; v < views.size(); ++v) {
      for (std::size_t i = 0; i < places.size(); ++i) {
        const Eigen::Vector3d point = to_camera * exact.poses[v] * places[i];
        views[v].camera[i] = project(scanner.camera, point);
        views[v].projector[i] = project(scanner.projector, in_projector_frame(scanner, point));
        for (Eigen::Vector2d* pixel : {&views[v].camera[i], &views[v].projector[i]}) {
          *pixel += Eigen::Vector2d(noise(random), noise(random));
        }
      }
    }
    all.push_back(std::move(views));
  }
  return all;
}

std::vector<GeometryCalibration> alone_of(const std::vector<Scanner>& scanners,
                                          const std::vector<BoardViews>& views) {
  std::vector<GeometryCalibration> alone;
  for (std::size_t c = 0; c < scanners.size(); ++c) {
    alone.push_back(calibrate_geometry(views[c], board, scanners[c].camera.size,
                                       scanners[c].projector.size,
                                       {.camera_coefficients = 4, .projector_coefficients = 4}));
  }
  return alone;
}

/// Sums of squared errors.
struct Errors {
  double pair_turn = 0, pair_shift = 0, rig_turn = 0, rig_shift = 0, focal = 0;
};

void add_errors(Errors& errors, const std::vector<Scanner>& found,
                const std::vector<Scanner>& truth) {
  const auto turn = [](const Eigen::Isometry3d& a, const Eigen::Isometry3d& b) {
    return std::pow(Eigen::AngleAxisd(a.linear().transpose() * b.linear()).angle(), 2);
  };
  for (std::size_t c = 0; c < found.size(); ++c) {
    errors.rig_turn += turn(rig_of(found[c]), rig_of(truth[c]));
    errors.rig_shift += (found[c].translation - truth[c].translation).squaredNorm();
    errors.focal += std::pow(found[c].camera.intrinsic(0, 0) - truth[c].camera.intrinsic(0, 0), 2);
    if (c == 0) continue;
    const Eigen::Isometry3d pair = between(found[0], found[c]), right = between(truth[0], truth[c]);
    errors.pair_turn += turn(pair, right);
    errors.pair_shift += (pair.translation() - right.translation()).squaredNorm();
  }
}

std::vector<Scanner> scanners_in(const std::vector<GeometryCalibration>& cameras) {
  std::vector<Scanner> scanners;
  for (const GeometryCalibration& camera : cameras) scanners.push_back(camera.state.scanner);
  return scanners;
}

/// Errors one by one and together, over some seeds.
std::pair<Errors, Errors> errors_of(std::size_t cameras, unsigned seeds) {
  const std::vector<Scanner> truth = true_scanners(cameras);
  Errors alone, together;
  for (unsigned seed = 1; seed <= seeds; ++seed) {
    const std::vector<GeometryCalibration> single = alone_of(truth, views_of(truth, 8, seed));
    add_errors(alone, scanners_in(single), truth);
    const CamerasCalibration joint = calibrate_together(single, printed_places(board), 20);
    add_errors(together, scanners_in(joint.cameras), truth);
  }
  return {alone, together};
}

void expect_better(const std::pair<Errors, Errors>& errors) {
  const auto& [alone, together] = errors;
  const auto ratio = [](double before, double after) { return std::sqrt(before / after); };

  fmt::print("errors alone / together: pair {:.2f} {:.2f}, rig {:.2f} {:.2f}, focal {:.2f}\n",
             ratio(alone.pair_turn, together.pair_turn),
             ratio(alone.pair_shift, together.pair_shift), ratio(alone.rig_turn, together.rig_turn),
             ratio(alone.rig_shift, together.rig_shift), ratio(alone.focal, together.focal));
  EXPECT_GT(ratio(alone.pair_turn, together.pair_turn), 1.3);
  EXPECT_GT(ratio(alone.pair_shift, together.pair_shift), 1.3);
  EXPECT_GT(ratio(alone.rig_turn, together.rig_turn), 1);
  EXPECT_GT(ratio(alone.rig_shift, together.rig_shift), 1);
  EXPECT_GT(ratio(alone.focal, together.focal), 1);
}

// Whichever camera's frame it goes through, a corner meets the same projector pixel.
TEST(SeveralCameras, SeeTheSamePointInTheProjectorsFrame) {
  const std::vector<Scanner> scanners = true_scanners(2);
  const BoardPlaces places = printed_places(board);
  const VirtualViews exact = virtual_views(scanners[0], board, places, 1, 0);
  const CamerasState state{
      .cameras = {scanners[0].camera, scanners[1].camera},
      .projector = scanners[0].projector,
      .rig = rig_of(scanners[0]),
      .cameras_from_first = {Eigen::Isometry3d::Identity(), between(scanners[0], scanners[1])},
      .poses = exact.poses,
      .places = places};
  const BundleState second = state_of_camera(state, {{{}, {}}, {{0}, {0}}}, 1);
  EXPECT_TRUE((rig_of(second.scanner) * second.poses[0]).isApprox(state.rig * state.poses[0]));
  EXPECT_TRUE(second.scanner.rotation.isApprox(scanners[1].rotation));
}

TEST(SeveralCameras, TogetherKnowTheirPoseBetter) {
  expect_better(errors_of(2, 3));
}

TEST(SeveralCameras, TwoAndThreeAreNoWorseThanAlone) {
  for (const std::size_t cameras : {2U, 3U}) expect_better(errors_of(cameras, 10));
}

TEST(SeveralCameras, ShareTheProjectorAndErrAsTheirSigmaSays) {
  const std::vector<Scanner> truth = true_scanners(2);
  std::vector<BoardViews> views = views_of(truth, 6, 3);

  // A pose that only one of them saw counts, too.
  views[1].erase(views[1].begin() + 2);
  const CamerasCalibration found =
      calibrate_together(alone_of(truth, views), printed_places(board), 20);

  const Scanner &first = found.cameras[0].state.scanner, &second = found.cameras[1].state.scanner;
  EXPECT_EQ(first.projector.intrinsic, second.projector.intrinsic);
  EXPECT_EQ(found.cameras[1].poses.size(), 5U);
  EXPECT_LT(found.cameras[1].rms.stereo, 0.25);

  ASSERT_EQ(found.poses.size(), 1U);
  EXPECT_TRUE(found.poses[0].pose.isApprox(between(first, second), 1e-6));
  const Eigen::Vector3d off =
      found.poses[0].pose.translation() - between(truth[0], truth[1]).translation();
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_LT(std::abs(off[axis]), 4 * found.poses[0].translation_sigma[axis]);
  }
}

TEST(SeveralCameras, MustShareTheirPoses) {
  const std::vector<Scanner> truth = true_scanners(2);
  std::vector<BoardViews> views = views_of(truth, 6, 3);
  for (BoardView& view : views[1]) view.name += " of another day";
  const std::vector<GeometryCalibration> alone = alone_of(truth, views);
  expect_error([&] { (void)calibrate_together(alone, printed_places(board), 20); },
               {"camera 2 shares 0 poses"});
  expect_error([&] { (void)calibrate_together({alone[0]}, printed_places(board), 20); },
               {"there is only one"});
}

TEST(SeveralCameras, HaveNoResidualMaps) {
  const std::vector<Scanner> truth = true_scanners(2);
  std::vector<GeometryCalibration> alone = alone_of(truth, views_of(truth, 6, 3));
  GeometryCalibrationSettings with_maps;
  with_maps.residual = true;
  expect_error([&] { (void)calibrate_together(alone, printed_places(board), 20, with_maps); },
               {"residual maps", "`residual`"});

  // A map that one of the cameras has already.
  alone[1].state.scanner.camera.residual.terms = {Eigen::Vector2d(0.1, 0)};
  expect_error([&] { (void)calibrate_together(alone, printed_places(board), 20); },
               {"residual maps"});
}

}  // namespace slipstream::several_cameras_test
