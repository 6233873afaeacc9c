#include "response/exposure_advice.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream::exposure_advice_test {

ExposureAdvice advice_for(const char* scene, std::vector<double> exposures,
                          double longest = ExposureNeeds{}.longest) {
  const Scanner scanner = example_scanner({320, 240});
  const Sequence sequence{.strategy = DualFrequency{}, .exposures = std::move(exposures)};
  const FrameSet frames = take_scan(scanner, scene_named(scene, scanner), pattern_set(sequence),
                                    {.ambient = 5, .noise_variance = 1.55})
                              .frames;
  return exposure_advice(frames, sequence, {.noise_variance = 1.63, .longest = longest});
}

TEST(ExposureAdvice, ProposesSeveralForASceneOfHighContrast) {
  const ExposureAdvice advice = advice_for("contrast", {0.25, 1, 4});
  ASSERT_EQ(advice.proposed.size(), 3U);
  ASSERT_EQ(advice.taken.size(), 4U);
  EXPECT_GE(advice.best, 1U);
  EXPECT_LT(advice.proposed[0].measured, 0.85);
  EXPECT_GT(advice.proposed[1].measured, advice.proposed[0].measured + 0.1);
  EXPECT_GT(advice.proposed[2].measured, 0.97);
  // What it says of its own exposures is so: of one taken alone as of all.
  EXPECT_NEAR(
      advice.taken[1].measured,
      advice_for("contrast", {1}).taken[0].measured * advice_for("contrast", {1}).lit / advice.lit,
      0.03);
}

TEST(ExposureAdvice, ProposesOneForAnEvenScene) {
  const ExposureAdvice advice = advice_for("board", {0.25, 1});
  EXPECT_EQ(advice.best, 0U);
  EXPECT_GT(advice.proposed[0].measured, 0.99);
  // The board's alpha of 0.8 and the ambient light just fit.
  EXPECT_NEAR(advice.proposed[0].exposures[0], 251 / (0.8 * 260 + 5), 0.15);
}

TEST(ExposureAdvice, SaysWhatIsSaturatedInAll) {
  const ExposureAdvice advice = advice_for("contrast", {4});
  EXPECT_GT(advice.unknown, 0.3);
}

TEST(ExposureAdvice, SaysWhichShareOfTheShortestExposureSuffices) {
  EXPECT_DOUBLE_EQ(advice_for("contrast", {4}, 2).light, 0.5);
}

TEST(ExposureAdvice, DarknessIsAnError) {
  const Sequence sequence{.strategy = PhaseMeasuring{.steps = 3}};
  const FrameSet black(FrameSet::Images8(3, Image<std::uint8_t>({8, 8})));
  EXPECT_THROW(exposure_advice(black, sequence), Error);
}

TEST(ExposureAdvice, RefusesNeedsThatNoPixelCanHave) {
  const Sequence sequence{.strategy = PhaseMeasuring{.steps = 3}};
  const FrameSet frames(FrameSet::Images8(3, Image<std::uint8_t>({8, 8})));
  for (const ExposureNeeds& needs :
       {ExposureNeeds{.least_modulation = 0}, ExposureNeeds{.least_modulation = 500},
        ExposureNeeds{.noise_variance = -1}, ExposureNeeds{.noise_variance = 8000}}) {
    try {
      exposure_advice(frames, sequence, needs);
      ADD_FAILURE();
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("out of range"), std::string::npos) << error.what();
    }
  }
}

}  // namespace slipstream::exposure_advice_test
