#include "calibrate/bundle_adjustment.h"

#include <random>

#include <gtest/gtest.h>

#include "calibrate/board_view.h"
#include "calibrate/corner_errors.h"
#include "calibrate/first_guess.h"
#include "calibrate/reprojection.h"
#include "slipstream/calibration_board.h"
#include "slipstream/named_scenes.h"
#include "tests/calibrate/virtual_views.h"

namespace slipstream::bundle_adjustment_test {

const CalibrationBoard board{.columns = 7, .rows = 5, .spacing = 20};

TEST(BundleAdjustment, OfExactCornersGivesTheTruth) {
  const Scanner truth = example_scanner();
  const auto places = printed_places(board);
  const VirtualViews boards = virtual_views(truth, board, places, 6, 0);
  BundleState state = first_guess(boards.views, places, truth.camera.size, truth.projector.size);
  state = bundle_adjusted(boards.views, std::move(state), places, {});
  const Scanner& found = state.scanner;
  EXPECT_TRUE(found.camera.intrinsic.isApprox(truth.camera.intrinsic, 1e-5));
  EXPECT_TRUE(found.projector.intrinsic.isApprox(truth.projector.intrinsic, 1e-5));
  EXPECT_TRUE(found.rotation.isApprox(truth.rotation, 1e-5));
  EXPECT_TRUE(found.translation.isApprox(truth.translation, 1e-4));
  for (const Eigen::Vector2d& residual : residuals(boards.views[0], state, 0, Device::camera)) {
    EXPECT_LT(residual.norm(), 1e-3);
  }
}

// Each map is a bow of two pixels: T_2 along both axes.
TEST(BundleAdjustment, KeepsTheResidualMapsOfBothLenses) {
  Scanner truth = example_scanner();
  for (Lens* lens : {&truth.camera, &truth.projector}) {
    const Eigen::Vector2d half(lens->size.width / 2.0, lens->size.height / 2.0);
    lens->residual = {.centre = half, .half = half, .terms = {6, Eigen::Vector2d(0, 0)}};
    lens->residual.terms[2] = {0, 2};
    lens->residual.terms[5] = {2, 0};
  }
  const auto places = printed_places(board);
  const VirtualViews boards = virtual_views(truth, board, places, 6, 0);
  const Scanner found =
      bundle_adjusted(boards.views, {truth, boards.poses, places}, places, {}).scanner;
  EXPECT_TRUE(found.camera.intrinsic.isApprox(truth.camera.intrinsic, 1e-5));
  EXPECT_TRUE(found.projector.intrinsic.isApprox(truth.projector.intrinsic, 1e-5));
  EXPECT_EQ(found.projector.residual, truth.projector.residual);
}

// Camera corners that are off move the projector's by the slope; that is not its own error.
TEST(BundleAdjustment, DeviationOfTheProjectorIsWithoutThatOfTheCamera) {
  const Scanner truth = example_scanner();
  const auto places = printed_places(board);
  VirtualViews boards = virtual_views(truth, board, places, 2, 0);
  Eigen::Matrix2d slope;
  slope << 1.7, 0.2, -0.15, 1.6;
  for (BoardView& view : boards.views) {
    view.slopes.assign(places.size(), slope);
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Eigen::Vector2d off = 0.3 * Eigen::Vector2d(i % 2 == 0 ? 1 : -1, i % 3 == 0 ? 1 : -1);
      view.camera[i] += off;
      view.projector[i] += slope * off;
    }
  }
  const PixelDeviations found = pixel_deviations(boards.views, {truth, boards.poses, places});
  EXPECT_NEAR(found.camera, 0.3 * 1.4826, 0.01);  // of a median
  EXPECT_LT(found.projector, 0.01);
}

TEST(BundleAdjustment, OneWrongCornerInAHundredHardlyMatters) {
  const Scanner truth = example_scanner();
  const auto places = printed_places(board);
  VirtualViews boards = virtual_views(truth, board, places, 6, 0.05);
  const BundleState start{truth, boards.poses, places};
  const BundleState clean = bundle_adjusted(boards.views, start, places, {});
  boards.views[2].camera[7] += Eigen::Vector2d(9, -6);
  boards.views[4].projector[9] += Eigen::Vector2d(-20, 11);
  const BundleState robust = bundle_adjusted(boards.views, start, places, {});
  EXPECT_NEAR(robust.scanner.camera.intrinsic(0, 0), clean.scanner.camera.intrinsic(0, 0), 0.2);
  EXPECT_NEAR(robust.scanner.translation.norm(), clean.scanner.translation.norm(), 0.05);
}

TEST(BundleAdjustment, ErrorsOfThePrintAreInStandardDeviations) {
  const PrintError error({1, 2, 3}, 0.5);
  const Eigen::Vector3d place(1, 2, 4);
  const double* const at = place.data();
  Eigen::Vector3d residual;
  ASSERT_TRUE(error.Evaluate(&at, residual.data(), nullptr));
  EXPECT_TRUE(residual.isApprox(Eigen::Vector3d(0, 0, 2)));
}

TEST(BundleAdjustment, FindsWhereABoardIsPrintedWrongly) {
  const Scanner truth = example_scanner();
  const auto printed = printed_places(board);
  std::vector<Eigen::Vector3d> real = printed;
  std::mt19937 random(4);
  std::normal_distribution<double> error(0, 0.1);
  for (Eigen::Vector3d& place : real) place += Eigen::Vector3d(error(random), error(random), 0);
  const VirtualViews boards = virtual_views(truth, board, real, 8, 0.02);
  const BundleState start{truth, boards.poses, printed};
  const BundleState found =
      bundle_adjusted(boards.views, start, printed, {.print_deviation = 0.25});
  const BundleState held = bundle_adjusted(boards.views, start, printed, {});
  const auto focal_error = [&](const BundleState& state) {
    return std::abs(state.scanner.camera.intrinsic(0, 0) - truth.camera.intrinsic(0, 0));
  };
  EXPECT_LT(focal_error(found), 0.5);  // 0.06 %
  EXPECT_LT(focal_error(found), 0.5 * focal_error(held));
}

TEST(BundleAdjustment, StandardDeviationsAreTheSpreadOfTheResults) {
  const Scanner truth = example_scanner();
  const auto places = printed_places(board);
  BundleDeviation deviation;
  double squares = 0, predicted = 0;
  constexpr int runs = 12;
  for (int run = 0; run < runs; ++run) {
    const VirtualViews boards =
        virtual_views(truth, board, places, 5, 0.1, static_cast<std::uint32_t>(run + 1));
    const BundleState found =
        bundle_adjusted(boards.views, {truth, boards.poses, places}, places, {}, &deviation);
    const double error = found.scanner.camera.intrinsic(0, 0) - truth.camera.intrinsic(0, 0);
    squares += error * error / runs;
    predicted += deviation.camera.focal.x() / runs;
  }
  EXPECT_GT(predicted, 0.5 * std::sqrt(squares));
  EXPECT_LT(predicted, 2 * std::sqrt(squares));
}

// The jackknife of two results that differ by 2 is sqrt(1/2 (1 + 1)) = 1.
TEST(BundleAdjustment, DeviationsAreWidenedToThoseOfTheJackknife) {
  const Scanner truth = example_scanner();
  Scanner less = truth, more = truth;
  less.camera.intrinsic(0, 0) -= 1;
  more.camera.intrinsic(0, 0) += 1;
  for (const double deviation : {0.5, 2.0}) {
    BundleDeviation before;
    before.camera.focal = {deviation, deviation};
    const BundleDeviation after = widened(before, {less, more});
    EXPECT_DOUBLE_EQ(after.camera.focal.x(), std::max(deviation, 1.0));
    EXPECT_DOUBLE_EQ(after.camera.focal.y(), deviation);
  }
}

TEST(BundleAdjustment, BoardQualityOfAnExactScannerIsPerfectAndOfAWrongOneIsNot) {
  const Scanner truth = example_scanner();
  const auto places = printed_places(board);
  const VirtualViews boards = virtual_views(truth, board, places, 2, 0);
  const auto exact = board_quality(boards.views[1], truth, places);
  ASSERT_TRUE(exact);
  EXPECT_LT(exact->flatness, 1e-6);
  EXPECT_LT(std::abs(exact->scale_error), 1e-8);
  Scanner larger = truth;
  larger.translation *= 1.01;
  const auto enlarged = board_quality(boards.views[1], larger, places);
  EXPECT_NEAR(enlarged->scale_error, 0.01, 1e-8);
  EXPECT_LT(exact->distance_error, 1e-6);
  EXPECT_GT(enlarged->distance_error, 0.01 * board.spacing);
  Scanner bent = truth;
  bent.camera.distortion = {};
  EXPECT_GT(board_quality(boards.views[1], bent, places)->flatness, 0.01);
}

}  // namespace slipstream::bundle_adjustment_test
