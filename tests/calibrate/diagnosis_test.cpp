#include "calibrate/diagnosis.h"

#include <string>
#include <tuple>
#include <vector>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "base/numbers.h"
#include "calibrate/board_view.h"
#include "slipstream/named_scenes.h"

namespace slipstream::diagnosis_test {

/// A calibration without faults, of eight poses with that rotation.
GeometryCalibration right_calibration(const Eigen::Matrix3d& turn = Eigen::Matrix3d::Identity()) {
  GeometryCalibration calibration;
  calibration.state.scanner = example_scanner();
  calibration.state.poses.assign(8, Eigen::Isometry3d(turn));
  calibration.poses.assign(8, {.name = "pose", .corners = 54, .lit = 54});
  calibration.views.resize(8);
  calibration.covered_camera = calibration.covered_projector = 1;
  calibration.largest_tilt = 40 * degree;
  return calibration;
}

/// What is said of it, a line each.
std::string said_of(const GeometryCalibration& calibration) {
  std::string said;
  for (const Finding& finding : findings_about(calibration)) said += text_of(finding) + "\n";
  return said;
}

// Some projectors' pixels are twice as high as wide, or as wide as high.
TEST(Diagnosis, PixelsOfAProjectorMayBeTwiceAsHighAsWide) {
  const auto told_of_height = [](double height) {
    GeometryCalibration calibration = right_calibration();
    calibration.state.scanner.projector.intrinsic(1, 1) /= height;
    return said_of(calibration);
  };
  for (const double height : {0.5, 1.0, 2.0}) EXPECT_EQ(told_of_height(height), "") << height;
  EXPECT_NE(told_of_height(0.9).find("another projector size"), std::string::npos);
}

// The edge that is nearer to the camera rises least along its depth.
TEST(Diagnosis, AsksForTheTiltsThatNoPoseHas) {
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
  for (const auto& [axis, angle, missing] :
       {std::tuple(x, 0.0, "left, right, upper, lower"), std::tuple(y, -0.3, "right, upper, lower"),
        std::tuple(y, 0.3, "left, upper, lower"), std::tuple(x, 0.3, "left, right, lower"),
        std::tuple(x, -0.3, "left, right, upper")}) {
    GeometryCalibration calibration = right_calibration(Eigen::AngleAxisd(angle, axis).matrix());
    calibration.largest_tilt = 0;
    const std::vector<Finding> findings = findings_about(calibration);
    ASSERT_EQ(findings.size(), 1U);
    EXPECT_TRUE(findings[0].remedies.at(0).text.ends_with(std::string("one each: ") + missing))
        << text_of(findings[0]);
  }
}

TEST(Diagnosis, NamesTheAxisAlongWhichAPoseIsShifted) {
  BoardView view{.name = "pose3"};
  const auto cause_of = [&](double x, double y) {
    return causes_of(finding_of_pose(view, {.mean = {x, y}, .spread = 0.1}));
  };
  EXPECT_TRUE(cause_of(-4, 0.3).ends_with("mostly along x")) << cause_of(-4, 0.3);
  EXPECT_TRUE(cause_of(0.3, -4).ends_with("mostly along y")) << cause_of(0.3, -4);
  EXPECT_TRUE(cause_of(3, 3).ends_with("moved during it")) << cause_of(3, 3);

  view.signs.y = {.steps = 8, .period = 800};
  EXPECT_TRUE(cause_of(0, 200).ends_with("wrong order, 2 steps late")) << cause_of(0, 200);
  EXPECT_TRUE(cause_of(0, 230).ends_with("mostly along y")) << cause_of(0, 230);
}

// A response affects all scans.
TEST(Diagnosis, ARippleInFewScansIsNoGamma) {
  std::vector<BoardView> views(4);
  for (BoardView& view : views) view.signs.x = view.signs.y = {.steps = 3, .period = 80};
  for (int rippled = 1; rippled <= 8; ++rippled) {
    const auto scan = static_cast<std::size_t>(rippled - 1);
    (scan % 2 == 0 ? views[scan / 2].signs.x : views[scan / 2].signs.y).ripple = 0.1;
    EXPECT_EQ(findings_of_frames(views).size(), rippled < 4 ? 0U : 1U) << rippled;
  }
  for (BoardView& view : views) view.signs.x.ripple_deviation = 0.05;
  for (BoardView& view : views) view.signs.y.ripple_deviation = 0.05;
  EXPECT_TRUE(findings_of_frames(views).empty()) << "may be noise";
}

TEST(Diagnosis, EdgesAreSoftBeyondTheBlurOfPixelsAndOfSmallSquares) {
  EXPECT_TRUE(is_soft({2, 0.2}));
  EXPECT_FALSE(is_soft({1, 0.2}));
  EXPECT_FALSE(is_soft({2, 0.1}));
}

// The lens model may not extrapolate to a pose: its corners then scatter.
TEST(Diagnosis, APoseThatIsShiftedIsNamedSoonerThanOneThatScatters) {
  const auto said_of_pose = [](double misfit, double spread) {
    GeometryCalibration calibration = right_calibration();
    calibration.poses[2].misfit = misfit;
    calibration.poses[2].offset = {.mean = {0, 4}, .spread = spread};
    return said_of(calibration);
  };
  EXPECT_EQ(said_of_pose(6, 10), "");
  EXPECT_NE(said_of_pose(6, 0.1), "");
  EXPECT_NE(said_of_pose(20, 10), "");
}

TEST(Diagnosis, ASinglePoseThatIsFarOffIsNoMovedRig) {
  const auto kind_of = [](double worst, double second) {
    GeometryCalibration calibration = right_calibration();
    calibration.moved = MovedRig{4, 2};
    for (CalibratedPose& pose : calibration.poses) pose.offset = {.mean = {0, 4}, .spread = 0.1};
    calibration.poses[4].misfit = worst;
    calibration.poses[5].misfit = second;
    return findings_about(calibration).at(0).kind;
  };
  EXPECT_EQ(kind_of(10, 9), FindingKind::two_rigs);
  EXPECT_EQ(kind_of(50, 9), FindingKind::odd_pose);
}

}  // namespace slipstream::diagnosis_test
