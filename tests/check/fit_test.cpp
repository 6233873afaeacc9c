#include "check/fit.h"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/check.h"
#include "slipstream/strategy.h"
#include "tests/check/mistakes.h"
#include "tests/check/scene_scan.h"

namespace slipstream::fit_test {

TEST(Fit, AllowsTheSlopesOfSlantedSurfacesAndTheirDoubt) {
  const auto fits = [](double slope, double doubt) {
    const Fit fit{.geometry = GeometryEvidence{.slope = slope, .slope_doubt = doubt}};
    return fit.geometry_fits();
  };
  EXPECT_TRUE(fits(1, 0));
  EXPECT_FALSE(fits(0.2, 0));
  EXPECT_TRUE(fits(0.2, 0.2));
  EXPECT_FALSE(fits(4, 0));
  EXPECT_TRUE(fits(4, 1.5));
}

/// A scan by a code alone.
Scan code_scan(const char* scene, const char* reference, int bits) {
  return scene_scan(scene, make_strategy("gray", {{"bits", bits}, {"reference", reference}}));
}

bool blames(const ScanFindings& found, CauseKind cause) {
  return std::ranges::any_of(found.findings, [&](const Finding& finding) {
    return std::ranges::count(finding.causes, cause, &Cause::kind) > 0;
  });
}

/// Sets, each with a scan of its own: a code's coordinate changes by whole stripes.
class FitCodeInSpace : public testing::TestWithParam<const char*> {
 protected:
  static void for_each_code(auto use) {
    for (const char* const reference : {"inverse", "white-black"}) {
      for (const int bits : {7, 8, 10}) use(code_scan(GetParam(), reference, bits), bits);
    }
  }
};

TEST_P(FitCodeInSpace, IsLeftInPeaceAsItIs) {
  for_each_code([](const Scan& scan, int bits) { EXPECT_EQ(told(check_scan(scan)), "") << bits; });
}

TEST_P(FitCodeInSpace, IsRefusedIfMirrored) {
  for_each_code([](Scan scan, int bits) {
    resampled([](double x, double y, Size size) { return std::pair(size.width - 1 - x, y); })(scan);
    const ScanFindings found = check_scan(scan);
    EXPECT_TRUE(any_wrong(found.findings)) << bits << ": " << told(found);
    EXPECT_TRUE(blames(found, CauseKind::picture_orientation)) << bits << ": " << told(found);
  });
}

TEST_P(FitCodeInSpace, IsRefusedAlongTheOtherAxis) {
  for_each_code([](Scan scan, int bits) {
    scan.sequence.axis = Axis::y;
    const ScanFindings found = check_scan(scan);
    EXPECT_TRUE(any_wrong(found.findings)) << bits << ": " << told(found);
    EXPECT_TRUE(blames(found, CauseKind::axis)) << bits << ": " << told(found);
  });
}

TEST_P(FitCodeInSpace, IsRefusedWithItsFirstFrameBlack) {
  for_each_code([](Scan scan, int bits) {
    pixels({0}, [](double, int, int) { return 1; })(scan);
    const ScanFindings found = check_scan(scan);
    EXPECT_TRUE(any_wrong(found.findings)) << bits << ": " << told(found);
  });
}

INSTANTIATE_TEST_SUITE_P(Scenes, FitCodeInSpace, testing::Values("statue", "board", "boxes"));

}  // namespace slipstream::fit_test
