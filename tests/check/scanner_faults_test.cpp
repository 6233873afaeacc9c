#include "check/scanner_faults.h"

#include <algorithm>
#include <functional>
#include <vector>

#include <gtest/gtest.h>

#include "check/geometric_mistakes.h"
#include "check/method_limits.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"

namespace slipstream::scanner_faults_test {

/// The kinds of what is said of the example scanner once it is changed.
std::vector<FindingKind> told_of(const std::function<void(Scanner&)>& change) {
  Scanner scanner = example_scanner();
  change(scanner);
  std::vector<FindingKind> kinds;
  for (const Finding& finding : check_scanner(scanner)) kinds.push_back(finding.kind);
  return kinds;
}

TEST(ScannerFaults, AxesMayLieAsFarFromTheCentreAsLensesPutThem) {
  using Kinds = std::vector<FindingKind>;
  const auto up = [](Lens Scanner::*lens, double share) {
    return told_of([&](Scanner& scanner) {
      (scanner.*lens).intrinsic(1, 2) = (0.5 + share) * (scanner.*lens).size.height;
    });
  };
  EXPECT_EQ(up(&Scanner::camera, 0.2), Kinds{});
  EXPECT_EQ(up(&Scanner::camera, 0.3), Kinds{FindingKind::off_centre_camera});
  EXPECT_EQ(up(&Scanner::projector, 1.1), Kinds{});
  EXPECT_EQ(up(&Scanner::projector, 1.3), Kinds{FindingKind::off_centre_projector});
}

TEST(ScannerFaults, WithoutRotationTheBaselineIsAlongAnAxis) {
  const auto without_rotation = [](const Eigen::Vector3d& baseline) {
    return told_of([&](Scanner& scanner) {
      scanner.rotation.setIdentity();
      scanner.translation = baseline;
    });
  };
  EXPECT_TRUE(without_rotation({150, 10, 0}).empty());
  EXPECT_EQ(without_rotation({150, 0, 60}), std::vector{FindingKind::oblique_baseline});
}

TEST(ScannerFaults, TooSmallARigOrTooNearAreOfAnotherUnit) {
  Scanner small = example_scanner();
  EXPECT_FALSE(small_scale(small, 500));
  EXPECT_TRUE(small_scale(small, 50));
  small.translation *= 20 / small.translation.norm();
  EXPECT_TRUE(small_scale(small, 500));
}

// X_p = R X_c + t, so that X_c = R^T X_p - R^T t.
TEST(ScannerFaults, OfAFileFromProjectorToCameraAreMendedByInvertingIt) {
  const Scanner right = example_scanner();
  Scanner file = right;
  file.rotation = right.rotation.transpose();
  file.translation = -(right.rotation.transpose() * right.translation);

  const auto mistakes = geometric_mistakes(file, {.strategy = make_strategy("gray-phase", {})});
  const auto inverted = std::ranges::find_if(mistakes, [](const PossibleMistake& mistake) {
    return mistake.cause.text.ends_with("go from the projector to the camera");
  });
  ASSERT_NE(inverted, mistakes.end());
  EXPECT_TRUE(inverted->scanner->rotation.isApprox(right.rotation));
  EXPECT_TRUE(inverted->scanner->translation.isApprox(right.translation));
}

}  // namespace slipstream::scanner_faults_test
