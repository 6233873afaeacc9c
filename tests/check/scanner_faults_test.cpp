#include "check/scanner_faults.h"

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "check/geometric_mistakes.h"
#include "check/method_limits.h"
#include "slipstream/check.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "tests/check/mistakes.h"
#include "tests/check/real_sets.h"
#include "tests/check/scene_scan.h"

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

/// The scan with its pictures moved to the left and up by shares of their size, and one grey level
/// where they end; `at_its_place`: not moved.
Scan padded(Scan scan, double across, double down, bool at_its_place = false) {
  const Size size = scan.frames.size();
  const int columns = static_cast<int>(across * size.width);
  const int rows = static_cast<int>(down * size.height);

  Pictures pictures = pictures_of(scan);
  for (Image<std::uint8_t>& picture : pictures) {
    Image<std::uint8_t> moved(size);
    for (int row = 0; row < size.height - rows; ++row) {
      for (int column = 0; column < size.width - columns; ++column) {
        moved(column, row) =
            at_its_place ? picture(column, row) : picture(column + columns, row + rows);
      }
    }
    picture = std::move(moved);
  }
  scan.frames = FrameSet(std::move(pictures));
  return scan;
}

/// Pixels without the border, columns and rows; empty if the check finds none.
std::vector<double> part_told(const Scan& scan) {
  std::vector<double> part;
  const std::vector<Finding> found = check_scan(scan).findings;
  for (const Finding& finding : found) {
    if (!finding.what.starts_with("the pictures end in a border")) continue;
    for (const Evidence& evidence : finding.evidence) part.push_back(evidence.value);
    EXPECT_EQ(found.size(), 1U) << "other pictures are not explained by other settings";
  }
  return part;
}

TEST(ScannerFaults, RegionsPaddedToFullSizeAreTold) {
  using Part = std::vector<double>;
  const Scan right = scene_scan("statue", make_strategy("dual-frequency", {{"steps", 4}}));

  EXPECT_EQ(part_told(right), Part());
  EXPECT_EQ(part_told(padded(right, 0.25, 0.2)), (Part{240, 192}));
  EXPECT_EQ(part_told(padded(right, 0.25, 0)), (Part{240, 240}));
  EXPECT_EQ(part_told(padded(right, 0, 0.2)), (Part{320, 192}));

  // Of a plane's frames other orders fit the scanner that does not.
  const Scan plane = scene_scan("board", make_strategy("dual-frequency", {{"steps", 4}}));
  EXPECT_EQ(part_told(padded(plane, 0.25, 0.2)), (Part{240, 192}));
}

// Pictures with a few dark columns are not of a region, wherever the lens has its axis.
TEST(ScannerFaults, NarrowBordersAreLeftInPeace) {
  Scan right = scene_scan("board", make_strategy("dual-frequency", {{"steps", 4}}));
  for (const double off_centre : {-0.01, 0.0, 0.01}) {
    right.scanner->camera.intrinsic(0, 2) = (0.5 + off_centre) * right.frames.size().width;
    for (const double across : {0.02, 0.04}) {
      EXPECT_EQ(part_told(padded(right, across, 0, true)), std::vector<double>())
          << across << ", axis off by " << off_centre;
    }
  }
}

TEST(ScannerFaults, RegionsOfARealScanPaddedToFullSizeAreTold) {
  if (!std::filesystem::exists(shared_data())) GTEST_SKIP() << shared_data() << " is not there";

  const Scan right = skull();
  EXPECT_EQ(part_told(right), std::vector<double>());
  EXPECT_EQ(part_told(padded(right, 0.25, 0.25)), (std::vector<double>{1266, 1014}));
}

// A camera that pads all its pictures is calibrated with them: its axis is in the middle of the
// rest.
TEST(ScannerFaults, PicturesThatWereCalibratedWithTheirBorderAreLeftInPeace) {
  Scan scan = padded(scene_scan("statue", make_strategy("dual-frequency", {{"steps", 4}})), 0.25,
                     0.2, true);
  scan.scanner->camera.intrinsic(0, 2) *= 0.75;
  scan.scanner->camera.intrinsic(1, 2) *= 0.8;
  EXPECT_EQ(part_told(scan), std::vector<double>());
}

}  // namespace slipstream::scanner_faults_test
