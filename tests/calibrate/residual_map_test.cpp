// Residual maps of calibrations, tried on poses that they were not fitted to.
#include "calibrate/residual_map.h"

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>
#include <fmt/core.h>
#include <gtest/gtest.h>

#include "calibrate/reprojection.h"
#include "slipstream/geometry_calibration.h"
#include "tests/calibrate/virtual_views.h"
#include "tests/io/expect_error.h"

namespace slipstream::residual_map_test {

const CalibrationBoard board{.columns = 13, .rows = 9, .spacing = 15};

/// The virtual world's `lens-residue`: off the model by this much, pixels.
Eigen::Vector2d residue(const Eigen::Vector2d& pixel, int width, double size) {
  const double u = 12 * pixel.x() / width, v = 12 * pixel.y() / width;
  return size * Eigen::Vector2d(std::sin(u + std::cos(v)), std::cos(v - u));
}

struct SeenBoards {
  BoardViews views;
  std::vector<Eigen::Isometry3d> poses;
};

/// Boards whose corners are where a camera with that residue sees them.
SeenBoards seen_boards(const Scanner& scanner, double size, double noise, int poses,
                       std::uint32_t seed = 1) {
  auto [views, true_poses] =
      virtual_views(scanner, board, printed_places(board), poses, noise, seed);
  for (BoardView& view : views) {
    for (Eigen::Vector2d& pixel : view.camera) {
      pixel -= residue(pixel, scanner.camera.size.width, size);
    }
  }
  return {std::move(views), std::move(true_poses)};
}

GeometryCalibration calibrated(const BoardViews& views, const Scanner& scanner, bool residual) {
  return calibrate_geometry(views, board, scanner.camera.size, scanner.projector.size,
                            {.camera_coefficients = 5,
                             .projector_coefficients = 5,
                             .print_deviation = std::nullopt,
                             .residual = residual});
}

/// RMS error of the camera's corners of other boards, pixels, with only their poses free.
double error_on(const BoardViews& others, const std::vector<Eigen::Isometry3d>& poses,
                const Scanner& found) {
  const BoardPlaces printed = printed_places(board);
  const BundleState state = bundle_adjusted(others, {found, poses, printed}, printed, all_held);

  return reprojection(others, state).camera.rms();
}

TEST(ResidualMap, IsFittedWithLensesAndPoses) {
  Scanner truth = example_scanner({640, 480});
  const Scanner model = truth;
  truth.camera.residual = {.centre = {319.5, 239.5}, .half = {320, 240}};
  // Of a shape that neither the lens models nor the poses have: terms of degrees 5 and 6.
  constexpr int degree = 6;
  for (int i = 0; i <= degree; ++i) {
    for (int j = 0; i + j <= degree; ++j) {
      const double size = i + j >= 5 ? 0.05 : 0;
      truth.camera.residual.terms.emplace_back(size, -size);
    }
  }

  const BoardPlaces printed = printed_places(board);
  const VirtualViews seen = virtual_views(truth, board, printed, 10, 0.005);
  const BundleState start{model, seen.poses, printed};
  const BundleState without = bundle_adjusted(seen.views, start, printed, {});
  const BundleState with =
      adjusted_with_residual(seen.views, start, printed, {}, {.camera = degree});

  const VirtualViews others = virtual_views(truth, board, printed, 7, 0);
  EXPECT_LT(error_on(others.views, others.poses, with.scanner),
            error_on(others.views, others.poses, without.scanner) / 4);
}

TEST(ResidualMap, LeavesAQuarterOfTheResidueOnOtherPoses) {
  const Scanner scanner = example_scanner({640, 480});
  constexpr double size = 0.1;
  const BoardViews views = seen_boards(scanner, size, 0.01, 16).views;
  const GeometryCalibration without = calibrated(views, scanner, false);
  const GeometryCalibration with = calibrated(views, scanner, true);
  const ResidualChoice& choice = with.camera_residual;
  for (const ResidualScore& score : choice.scores) {
    fmt::print("degree {}: held-out corners off by {:.4f} px\n", score.degree, score.rms);
  }

  const SeenBoards others = seen_boards(scanner, size, 0, 9, 7);
  const double before = error_on(others.views, others.poses, without.state.scanner);
  const double after = error_on(others.views, others.poses, with.state.scanner);
  fmt::print("chosen degree {}; other corners off by {:.4f} px instead of {:.4f} px\n",
             choice.degree, after, before);
  EXPECT_GE(choice.degree, 6);
  EXPECT_GE(before, 4 * after);
}

TEST(ResidualMap, MakesRigsWithoutResidueNoWorse) {
  const char* const asked = std::getenv("SLIPSTREAM_RIGS");
  const int rigs = asked != nullptr ? std::atoi(asked) : 2;
  const Scanner scanner = example_scanner({640, 480});
  double before = 0, after = 0;
  for (int rig = 1; rig <= rigs; ++rig) {
    const auto seed = static_cast<std::uint32_t>(rig);
    const BoardViews views = seen_boards(scanner, 0, 0.05, 8, seed).views;
    const SeenBoards others = seen_boards(scanner, 0, 0, 9, seed + 1000);
    for (const bool residual : {false, true}) {
      const Scanner found = calibrated(views, scanner, residual).state.scanner;
      const double error = error_on(others.views, others.poses, found);
      (residual ? after : before) += error * error;
    }
  }
  fmt::print("other corners of {} rigs off by {:.4f} px instead of {:.4f} px\n", rigs,
             std::sqrt(after / rigs), std::sqrt(before / rigs));
  EXPECT_LE(std::sqrt(after), 1.02 * std::sqrt(before));
}

TEST(ResidualMap, IsRefusedForFewPoses) {
  const Scanner scanner = example_scanner({640, 480});
  const BoardViews views = seen_boards(scanner, 0, 0.02, 5).views;
  expect_error([&] { calibrated(views, scanner, true); }, {"a residual map requires 6"});
}

}  // namespace slipstream::residual_map_test
