#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "frames/pattern_windows.h"
#include "slipstream/geometry_calibration.h"
#include "slipstream/named_scenes.h"
#include "tests/calibrate/virtual_views.h"
#include "tests/io/expect_error.h"

namespace slipstream::verification_test {

constexpr double degree = std::numbers::pi / 180;
const CalibrationBoard board{.columns = 9, .rows = 6, .spacing = 20};

std::vector<BoardView> views_of(const Scanner& scanner, int count) {
  return virtual_views(scanner, board, printed_places(board), count, 0.05).views;
}

/// Rotates and shifts the projector, as a knock does.
Scanner knocked(Scanner scanner, double angle, double shift) {
  const Eigen::Vector3d axis = Eigen::Vector3d(1, 0.7, 0.2).normalized();
  scanner.rotation = Eigen::AngleAxisd(angle, axis) * scanner.rotation;
  scanner.translation += shift * Eigen::Vector3d(0.6, -0.5, 0.6).normalized();
  return scanner;
}

TEST(Verification, AScannerThatIsRightHolds) {
  const Scanner truth = example_scanner();
  const Verification found = verify_scanner(views_of(truth, 3), board, truth);
  EXPECT_TRUE(found.holds);
  EXPECT_FALSE(found.mended);
  EXPECT_TRUE(found.findings.empty());
  EXPECT_LT(found.before.epipolar, 0.15);
  EXPECT_LT(found.before.quality.scale_error, 0.001);
  EXPECT_LT(found.rotation, 0.05 * degree);
}

// Each projector pixel moves across its epipolar line.
TEST(Verification, EpipolarDistanceIsInProjectorPixels) {
  const Scanner scanner = example_scanner();
  std::vector<BoardView> views = views_of(scanner, 2);
  for (BoardView& view : views) {
    for (std::size_t i = 0; i < view.projector.size(); ++i) {
      const Eigen::Vector3d ray = ray_through(scanner.camera, view.camera[i]);
      const Eigen::Vector3d line = scanner.translation.cross(scanner.rotation * ray);
      view.projector[i] += 3 * line.head<2>().normalized();
    }
  }
  EXPECT_NEAR(verify_scanner(views, board, scanner).before.epipolar, 3, 0.1);
}

TEST(Verification, AKnockIsToldAndCorrected) {
  const Scanner old = example_scanner();
  const Scanner now = knocked(old, 0.5 * degree, 1);
  for (const int count : {1, 4}) {
    const Verification found = verify_scanner(views_of(now, count), board, old);
    EXPECT_FALSE(found.holds) << count;
    ASSERT_TRUE(found.mended) << count << " poses, epipolar " << found.after.epipolar;
    ASSERT_EQ(found.findings.size(), 1U);
    EXPECT_NE(causes_of(found.findings[0]).find("moved relative to each other"), std::string::npos);
    EXPECT_NEAR(found.rotation, 0.5 * degree, (count == 1 ? 0.2 : 0.05) * degree);
    EXPECT_LT(found.after.epipolar, 0.15);
    EXPECT_GT(found.before.epipolar, 2);
    EXPECT_EQ(found.corrected.camera, old.camera);
    EXPECT_EQ(found.corrected.projector, old.projector);
  }
  const Scanner corrected = verify_scanner(views_of(now, 4), board, old).corrected;
  EXPECT_LT((corrected.translation - now.translation).norm(), 0.5);
}

TEST(Verification, AnotherLensIsNotMendedByAMove) {
  const Scanner old = example_scanner();
  Scanner now = old;
  now.camera.intrinsic(0, 0) *= 1.03;
  now.camera.intrinsic(1, 1) *= 1.03;
  const Verification found = verify_scanner(views_of(now, 4), board, old);
  EXPECT_FALSE(found.holds);
  EXPECT_FALSE(found.mended);
  ASSERT_FALSE(found.findings.empty());
  EXPECT_NE(causes_of(found.findings.back()).find("zoom"), std::string::npos);
}

TEST(Verification, AWrongSpacingIsNoMove) {
  const Scanner truth = example_scanner();
  CalibrationBoard said = board;
  said.spacing = 20.4;
  const Verification found = verify_scanner(views_of(truth, 4), said, truth);
  EXPECT_FALSE(found.holds);
  EXPECT_GT(found.before.quality.distance_error, 0.5);  // mm
  EXPECT_FALSE(found.mended);
  ASSERT_FALSE(found.findings.empty());
  EXPECT_NE(causes_of(found.findings.back()).find("another spacing"), std::string::npos);
  EXPECT_NE(remedies_of(found.findings.back()).find("20 mm"), std::string::npos)
      << remedies_of(found.findings.back());
}

TEST(Verification, WithoutABoardIsAnError) {
  expect_error([] { (void)verify_scanner({}, board, example_scanner()); }, {"no pose"});
}

}  // namespace slipstream::verification_test
