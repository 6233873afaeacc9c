#include "check/unrelated_pixels.h"

#include <random>
#include <string>

#include <gtest/gtest.h>

#include "slipstream/check.h"
#include "slipstream/strategy.h"

namespace slipstream::unrelated_pixels_test {

/// What is said of noise, or of noise with half of the first frame saturated.
ScanFindings findings_of_noise(const Strategy& strategy, bool saturated) {
  std::mt19937 random(3);
  FrameSet::Images8 pictures;
  for (int n = 0; n < strategy.layout().frames; ++n) {
    Image<std::uint8_t>& picture = pictures.emplace_back(Size{160, 120});
    for_each_pixel_in_order(picture.size(), [&](int column, int row) {
      const bool white = saturated && n == 0 && column % 4 < 2;
      picture(column, row) = white ? 255 : static_cast<std::uint8_t>(random() % 255);
    });
  }
  return check_frames(FrameSet(std::move(pictures)), {.strategy = strategy}, {});
}

TEST(UnrelatedPixels, OfNoiseAreRefused) {
  for (const Strategy& strategy :
       {make_strategy("dual-frequency", {}), make_strategy("gray", {{"reference", "inverse"}}),
        make_strategy("gray-phase", {}), make_strategy("micro", {}), make_strategy("pmp", {})}) {
    const ScanFindings found = findings_of_noise(strategy, false);
    ASSERT_EQ(found.findings.size(), 1U) << label_of(strategy);
    EXPECT_EQ(found.findings.front().kind, FindingKind::excess_noise) << label_of(strategy);
    EXPECT_TRUE(any_wrong(found.findings)) << label_of(strategy);
  }
}

TEST(UnrelatedPixels, AreNotAllThatIsSaidOfSaturatedPictures) {
  const ScanFindings found = findings_of_noise(make_strategy("dual-frequency", {}), true);
  EXPECT_EQ(found.findings.at(0).kind, FindingKind::saturated) << text_of(found.findings.at(0));
}

}  // namespace slipstream::unrelated_pixels_test
