// Frames without a scene: levels of pixels that follow from an equation.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "base/numbers.h"
#include "check/code_evidence.h"
#include "check/colour_mosaic.h"
#include "check/damaged_frames.h"
#include "check/dark_frames.h"
#include "check/explanations.h"
#include "check/fit.h"
#include "check/frame_faults.h"
#include "check/method_limits.h"
#include "check/mistake_search.h"
#include "check/phase_noise.h"
#include "check/unrelated_pixels.h"
#include "check/waveform.h"
#include "check/wrapped_levels.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "tests/check/synthetic_scan.h"

namespace slipstream::synthetic_frames_test {

const Strategy sinusoids = make_strategy("dual-frequency", {{"steps", 4}});

TEST(SyntheticFrames, ReachTheTopAtACrestWithoutClipping) {
  const SyntheticScan scan(sinusoids, shown(sinusoids, 20, 180));
  EXPECT_TRUE(light_faults(scan.model, scan.samples, 8, 15).empty());
}

TEST(SyntheticFrames, TellTheirBits) {
  for (const int bits : {10, 12, 14}) {
    const double top = (1 << bits) - 1;
    const SyntheticScan scan(sinusoids, shown(sinusoids, 0.1 * top, 0.8 * top), 16);
    const Finding finding = light_faults(scan.model, scan.samples, 16, 15).at(0);
    EXPECT_EQ(finding.remedies.at(0).settings,
              (std::vector<SettingChange>{{"camera_bits", std::to_string(bits)}}))
        << text_of(finding);
  }
}

// An exposure that suffices is 20 / 18 times as long: the brighter room would then saturate.
TEST(SyntheticFrames, TooDimAreBlamedOnTheRoomIfMoreExposureSaturates) {
  for (const auto& [mean, kind] : {std::pair(233, FindingKind::strong_ambient_light),
                                   std::pair(120, FindingKind::low_modulation)}) {
    const SyntheticScan scan(sinusoids, shown(sinusoids, mean - 18, 36), 8, 30);
    const std::vector<Finding> findings = light_faults(scan.model, scan.samples, 8, 20);
    ASSERT_EQ(findings.size(), 1U) << mean;
    EXPECT_EQ(findings.front().kind, kind) << mean;
  }
}

TEST(SyntheticFrames, TooDimInOneBandAreBlurred) {
  const SyntheticScan scan(sinusoids, [](int n, int column, int) {
    return 120 + (n < 4 ? 20 : 200) * (sinusoids.shape(n, along(column)) - 0.5);
  });
  const std::vector<Finding> findings = light_faults(scan.model, scan.samples, 8, 15);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings.front().kind, FindingKind::low_modulation);
  EXPECT_TRUE(blames(findings.front(), CauseKind::blur)) << text_of(findings.front());
}

TEST(SyntheticFrames, AllWhiteAreOverexposed) {
  const SyntheticScan scan(sinusoids, [](int, int, int) { return 255; });
  const Finding finding = light_faults(scan.model, scan.samples, 8, 15).at(0);
  EXPECT_TRUE(blames(finding, CauseKind::overexposure)) << text_of(finding);
}

TEST(SyntheticFrames, OfPixelsWithoutLitNeighboursAreNoNoise) {
  const Level pattern = shown(sinusoids, 20, 200);
  const SyntheticScan scan(sinusoids, [&](int n, int column, int row) {
    return column % 2 + row % 2 == 0 ? pattern(n, column, row) : 20;
  });
  EXPECT_FALSE(unrelated_pixels(scan.samples));
}

// Noise s of a relation, periods, leaves a coherence of exp(-2 pi^2 s^2). Here it is that of the
// coarse phase, of four steps, times the ratio of the periods.
TEST(SyntheticFrames, TellTheNoiseOfARelation) {
  constexpr double amplitude = 100, noise = 9, ratio = 16;
  std::mt19937 random(1);
  std::normal_distribution<double> deviate(0, noise);
  const Level pattern = shown(sinusoids, 20, 2 * amplitude);
  const SyntheticScan scan(sinusoids, [&](int n, int column, int row) {
    return pattern(n, column, row) + deviate(random);
  });
  FrameJudge judge(scan.model);
  const BandRelation relation = judge(scan.samples, scan.model.identity()).relations.at(0);
  const double of_relation = ratio * std::sqrt(2.0 / 4) * noise / amplitude / two_pi;
  EXPECT_NEAR(relation.noise, std::exp(-std::pow(two_pi * of_relation, 2) / 2), 0.05);
  EXPECT_NEAR(relation.agreement, 1, 0.1);
}

TEST(SyntheticFrames, ThroughAKnownResponseLeaveNothingUnexplained) {
  const Strategy strategy = make_strategy("dual-frequency", {{"steps", 6}});
  const Level light = shown(strategy, 0, 1);
  const SyntheticScan scan(
      strategy,
      [&](int n, int column, int row) { return 200 * std::pow(light(n, column, row), 2.2); }, 8, 22,
      MeasuredResponse{PowerLaw{2.2}, 2.2});
  FrameJudge judge(scan.model);
  EXPECT_LT(judge(scan.samples, scan.model.identity()).residual, 0.01);
}

TEST(SyntheticFrames, OfAColourMosaicGiveTheRatioOfItsGains) {
  const Level grey = shown(sinusoids, 20, 200);
  const SyntheticScan scan(sinusoids, [&](int n, int column, int row) {
    return grey(n, column, row) / ((column + row) % 2 + 1);
  });
  const std::optional<Finding> mosaic = colour_mosaic(scan.samples);
  ASSERT_TRUE(mosaic);
  EXPECT_NEAR(mosaic->evidence.front().value, 2, 0.02);
}

// Few pixels of other brightness each: their median ratio is 1.1 by chance.
TEST(SyntheticFrames, OfUnlikePixelsHaveNoMosaic) {
  std::mt19937 random(8);
  Image<double> ranges(size);
  for (double& range : ranges) range = 20 + static_cast<double>(random() % 180);
  const SyntheticScan scan(
      make_strategy("pmp", {{"steps", 3}}),
      [&](int n, int column, int row) {
        return column < 4 && n == 0 ? 20 + ranges(column, row) : 20;
      },
      8, 15);
  EXPECT_FALSE(colour_mosaic(scan.samples));
}

// All pixels see the first 16th of the field, where four of five bits are dark.
TEST(SyntheticFrames, OfADarkPartOfTheFieldAreNotCalledBlack) {
  const Strategy code = make_strategy("gray", {{"bits", 5}});
  const SyntheticScan scan(
      code, [&](int n, int column, int) { return 20 + 200 * code.shape(n, along(column) / 16); });
  EXPECT_TRUE(dark_frames(scan.judged()).empty());
}

// A gamma widens the dark part of a sinusoid, and leaves its edges soft.
TEST(SyntheticFrames, WithADarkPartLackNoRows) {
  const SyntheticScan scan(sinusoids, [](int n, int, int row) {
    return 200 * std::pow(sinusoids.shape(n, static_cast<double>(row) / size.height), 2.2);
  });
  EXPECT_TRUE(damaged_frames(scan.samples).empty());
}

// Noise of 4 grey levels changes a neighbour in the same frames by more than 4 in 24 % of the
// pixels: by normal deviates.
TEST(SyntheticFrames, OfNoiseAreNotDim) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(40, 4);
  const Level pattern = shown(sinusoids, 20, 200);
  const SyntheticScan scan(sinusoids, [&](int n, int column, int row) {
    return column < 0.3 * size.width ? pattern(n, column, row) : noise(random);
  });
  EXPECT_LT(scan.samples.dim_share(), 0.5);
}

/// The code's evidence of frames that show one strategy and are read as another.
CodeEvidence code_of(const Strategy& read, const Level& level) {
  const SyntheticScan scan(read, level);
  return code_evidence(scan.model, scan.samples, scan.model.identity());
}

// An edge lies between two pixels. Its offset is one of the origin beyond a tenth of a pixel, here
// 0.01 periods, more than the limit of 0.035.
TEST(SyntheticFrames, OfACodeGiveTheErrorOfTheOrigin) {
  const auto with_origin = [](double origin) {
    return make_strategy("gray-phase", {{"periods", 32}, {"bits", 5}, {"origin", origin}});
  };
  const auto offset_of = [&](double error) {
    return code_of(with_origin(0), shown(with_origin(two_pi * error), 20, 200)).offset;
  };
  EXPECT_NEAR(offset_of(0), 0, 0.01);
  EXPECT_LE(std::abs(offset_of(0.04)), 0.035);
  EXPECT_NEAR(std::abs(offset_of(0.06)), 0.06, 0.01);
}

TEST(SyntheticFrames, OfShiftsTheOtherWayRunAgainstTheCode) {
  const auto running = [](bool backwards) {
    return make_strategy("gray-phase", {{"periods", 32}, {"bits", 5}, {"backwards", backwards}});
  };
  EXPECT_EQ(code_of(running(false), shown(running(false), 20, 200)).against, 0);
  EXPECT_EQ(code_of(running(false), shown(running(true), 20, 200)).against, 1);
}

// White and black, frames 5 and 6, part the bits; the first of 32 stripes is dark in all of these.
TEST(SyntheticFrames, OfACodeWithoutWhiteOrBlackAreDisordered) {
  const Strategy code = make_strategy("gray", {{"bits", 5}, {"reference", "white-black"}});
  const auto disordered = [&](int white, int black) {
    return code_of(
               code,
               [&](int n, int column, int) {
                 return n < 5 ? 20 + 200 * code.shape(n, along(column)) : n == 5 ? white : black;
               })
        .disordered;
  };
  EXPECT_EQ(disordered(220, 20), 0);
  EXPECT_NEAR(disordered(220, 220), 31.0 / 32, 0.01);
  EXPECT_NEAR(disordered(20, 20), 31.0 / 32, 0.01);
}

// Then every second stripe seems to be followed by the next but one.
TEST(SyntheticFrames, OfAPlainCodeMayHaveTheFinestBitAside) {
  const Strategy code = make_strategy("gray", {{"bits", 5}, {"plain", true}});
  const CodeEvidence evidence = code_of(code, [&](int n, int column, int) {
    return 20 + 200 * code.shape(n, along(n == 4 ? column - 2 : column));
  });
  EXPECT_EQ(evidence.torn, 0);
}

// 10 pixels to a stripe, so that the camera sees all; frames 8 to 9 are of the finest bit.
TEST(SyntheticFrames, OfBitsBesideTheInversesOfOthersAreUnpaired) {
  const Strategy code = make_strategy("gray", {{"bits", 5}, {"reference", "inverse"}});
  EXPECT_EQ(code_of(code, shown(code, 20, 200)).unpaired, 0);
  for (const int swapped : {6, 7}) {
    const CodeEvidence evidence = code_of(code, [&](int n, int column, int) {
      return 20 + 200 * code.shape(n == 8 ? swapped : n == swapped ? 8 : n, along(column));
    });
    EXPECT_NEAR(evidence.unpaired, 0.25, 0.05) << swapped;
  }
}

TEST(SyntheticFrames, OfAPlainCodeTellItsFinestBitsApart) {
  const Strategy code = make_strategy("gray", {{"bits", 5}, {"plain", true}});
  const CodeEvidence evidence = code_of(code, [&](int n, int column, int) {
    return 20 + 200 * code.shape(n < 3 ? n : 7 - n, along(column));
  });
  EXPECT_GT(evidence.torn, 0.5);
}

// The camera does not part the finest stripes.
TEST(SyntheticFrames, OfACodeBlurFinerStripesFirst) {
  for (const bool plain : {false, true}) {
    const Strategy code = make_strategy("gray", {{"bits", 6}, {"plain", plain}});
    for (const bool swapped : {false, true}) {
      const CodeEvidence evidence = code_of(code, [&](int n, int column, int) {
        return n == (swapped ? 4 : 5)
                   ? 120
                   : 20 + 200 * code.shape(swapped && n == 5 ? 4 : n, along(column));
      });
      EXPECT_EQ(evidence.blurred > 0.5, swapped) << plain;
    }
  }
}

TEST(SyntheticFrames, OfSinglePeriodsGiveTheErrorOfTheOrigin) {
  const Strategy off = make_strategy("micro", {{"origin", 0.1}});
  const SyntheticScan scan(make_strategy("micro", {}), shown(off, 20, 200));
  FrameJudge judge(scan.model);
  EXPECT_NEAR(judge(scan.samples, scan.model.identity()).origin, 0.1, 0.02);
}

// A tenth less of the fringes beside the cue; the tried losses are 0.05 apart.
TEST(SyntheticFrames, TellHowMuchBlurDampsFringes) {
  constexpr int steps = 4;
  const Strategy strategy = make_strategy("pcmp", {{"steps", steps}, {"high", 8}});
  const SyntheticScan scan(strategy, [&](int n, int column, int) {
    double fringe = 0;
    for (int m = 0; m < steps; ++m) {
      fringe += strategy.shape(m, along(column)) * std::cos(two_pi * (n - m) / steps) * 2 / steps;
    }
    return 20 + 200 * (strategy.shape(n, along(column)) - 0.1 * fringe);
  });
  FrameJudge judge(scan.model);
  EXPECT_NEAR(judge(scan.samples, scan.model.identity()).damping, 0.1, 0.051);
}

// The light is constant over two camera pixels, a tenth of a period. The phase within a projector
// pixel is uniformly distributed, with the variance 1 / 12.
TEST(SyntheticFrames, OfCoarseProjectorPixelsAreNotNoisy) {
  const Strategy strategy = make_strategy("dual-frequency", {{"steps", 4}, {"high", 32}});
  const SyntheticScan scan(strategy, [&](int n, int column, int row) {
    return 20 + 200 * strategy.shape(n, along((column + row) / 2));
  });
  EXPECT_NEAR(phase_noise(scan.model, scan.judged()).by_pixel, two_pi / 10 / std::sqrt(12), 1e-6);
  for (const Finding& finding : method_limits(scan.judged(), {})) {
    EXPECT_NE(finding.kind, FindingKind::excess_noise) << text_of(finding);
  }
}

// A gamma of 1.4 is 1.28 to first order. In a 64th of the field it looks like ambient light.
TEST(SyntheticFrames, TellTheirGammaOrThatItIsUnproven) {
  const Strategy strategy = make_strategy("pmp", {{"steps", 3}});
  const auto finding_of = [&](double gamma, double part) {
    const SyntheticScan scan(strategy, [&](int n, int column, int) {
      return 5 + 230 * std::pow(strategy.shape(n, 0.1 + part * along(column)), gamma);
    });
    return method_limits(scan.judged(), {}).at(0);
  };
  const Finding bent = finding_of(1.4, 1);
  EXPECT_EQ(bent.kind, FindingKind::nonlinear_light) << text_of(bent);
  EXPECT_NEAR(bent.evidence.front().value, 1.28, 0.03);
  EXPECT_EQ(finding_of(1, 1.0 / 64).kind, FindingKind::unproven_response);
}

// Depth moves stripes of either axis away from the epipole, if that lies in the field.
TEST(SyntheticFrames, RunAlongABaselineThatMovesTheOtherAxis) {
  const SyntheticScan scan(sinusoids, shown(sinusoids, 20, 200));
  const auto warns = [&](const Eigen::Vector3d& baseline) {
    Scanner scanner = example_scanner(size);
    scanner.translation = baseline;
    const Fit fit{.geometry = GeometryEvidence{.median_depth = 600}};
    return !method_limits(scan.judged(&scanner), fit).empty();
  };
  EXPECT_FALSE(warns({150, 0, 0}));
  EXPECT_TRUE(warns({0, 150, 0}));
  EXPECT_FALSE(warns({20, 20, 150}));
}

// Rounding alone then leaves another coordinate that fits almost as well.
TEST(SyntheticFrames, OfAFewGreyLevelsAreNoDoubt) {
  const Strategy micro = make_strategy("micro", {});
  const SyntheticScan scan(micro, shown(micro, 50, 3), 8, 1);
  FrameJudge judge(scan.model);
  EXPECT_EQ(judge(scan.samples, scan.model.identity()).doubt, 0);
}

/// Blurred stripes: odd harmonics k with the factors s^((k^2 - 1) / 8) / k.
Level stripes(const Strategy& strategy, double s) {
  return [=](int n, int column, int) {
    const double c = 2 * strategy.shape(n, along(column)) - 1;
    const double third = 4 * c * c * c - 3 * c, fifth = c * (16 * std::pow(c, 4) - 20 * c * c + 5);
    return 120 + 100 * (c - s / 3 * third + std::pow(s, 3) / 5 * fifth);
  };
}

TEST(SyntheticFrames, OfStripesTellTheErrorOfTheirPhase) {
  const Strategy strategy = make_strategy("dual-frequency", {{"steps", 6}});
  const SyntheticScan scan(strategy, stripes(strategy, 0.6));
  const auto waveform = waveform_of(scan.model, scan.judged(), scan.model.identity());
  ASSERT_TRUE(waveform);

  double square = 0;
  SampleReading reading;
  for (std::size_t g = 0; g < scan.samples.groups(); ++g) {
    scan.model.read(scan.samples.levels(g, ScanSamples::middle), scan.model.identity(), reading);
    const std::size_t band = scan.model.measuring_band();
    const double truth =
        two_pi * scan.model.layout().bands[band].periods * along(scan.samples.column(g));
    square += std::pow(std::remainder(reading.phase[band] - truth, two_pi), 2);
  }
  const double error = std::sqrt(square / static_cast<double>(scan.samples.groups()));
  EXPECT_NEAR(waveform->phase_error, error, 0.25 * error);  // to first order
}

// Their fifth harmonic bends the phase of four periods by more than the noise of rounding.
TEST(SyntheticFrames, OfSharpStripesAreCalledOneBitPatterns) {
  const Strategy strategy = make_strategy("dual-frequency", {{"steps", 6}, {"high", 4}});
  const SyntheticScan scan(strategy, stripes(strategy, 0.8));
  const auto findings = explain(scan.judged(), fit_of(scan.judged())).findings;
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings.front().severity, Severity::doubtful);
  EXPECT_EQ(std::ranges::count(findings.front().causes, CauseKind::noise, &Cause::kind), 1);
}

// Levels that wrap around change all the same way.
TEST(SyntheticFrames, OfTwoSurfacesHaveNotWrapped) {
  const SyntheticScan scan(make_strategy("pmp", {{"steps", 5}}), [](int n, int column, int) {
    return n > 1 ? 120 : n == column % 2 ? 220 : 20;
  });
  EXPECT_FALSE(wrapped_levels(scan.model.layout(), scan.samples));

  // Nor have those that change in another frame, too.
  const SyntheticScan other(make_strategy("pmp", {{"steps", 5}}), [](int n, int column, int) {
    const std::array here{20, 220, 120, 120, 20}, there{220, 220, 150, 120, 20};
    return (column % 2 == 0 ? here : there).at(static_cast<std::size_t>(n));
  });
  EXPECT_FALSE(wrapped_levels(other.model.layout(), other.samples));
}

}  // namespace slipstream::synthetic_frames_test
