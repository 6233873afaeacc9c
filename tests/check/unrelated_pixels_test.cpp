#include "check/unrelated_pixels.h"

#include <random>
#include <string>

#include <gtest/gtest.h>

#include "slipstream/check.h"
#include "slipstream/strategy.h"

namespace slipstream::unrelated_pixels_test {

TEST(UnrelatedPixels, OfNoiseAreRefused) {
  for (const Strategy& strategy :
       {make_strategy("dual-frequency", {}), make_strategy("gray", {{"reference", "inverse"}}),
        make_strategy("gray-phase", {}), make_strategy("micro", {}), make_strategy("pmp", {})}) {
    std::mt19937 random(3);
    FrameSet::Images8 pictures;
    for (int n = 0; n < strategy.layout().frames; ++n) {
      Image<std::uint8_t>& picture = pictures.emplace_back(Size{160, 120});
      for (std::uint8_t& level : picture) level = static_cast<std::uint8_t>(random() % 255);
    }

    const ScanFindings found =
        check_frames(FrameSet(std::move(pictures)), {.strategy = strategy}, {});
    ASSERT_EQ(found.findings.size(), 1U) << label_of(strategy);
    EXPECT_EQ(found.findings.front().kind, FindingKind::excess_noise) << label_of(strategy);
    EXPECT_TRUE(any_wrong(found.findings)) << label_of(strategy);
  }
}

}  // namespace slipstream::unrelated_pixels_test
