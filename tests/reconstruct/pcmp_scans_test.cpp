// Virtual PCMP scans: at their true depth without noise, and with noise no point of a wrong order.
#include <array>
#include <cmath>

#include <gtest/gtest.h>

#include "decode/equations.h"
#include "reconstruct/pipeline.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/simulate/traced_scene.h"

namespace slipstream::pcmp_scans_test {

constexpr PatternLight light{.alpha_p = 200, .beta_p = 55};
constexpr double ambient = -5;

PhaseChannelMultiplexing pcmp(int steps) {
  return {.steps = steps, .high = {}, .share = {}, .reference = {}};
}

/// In double.
ReferenceEngine engine(Scanner scanner, int steps, Axis axis, CueRule rule,
                       PhaseMethod method = PhaseMethod::tables) {
  scanner.photometry.ambient = ambient;
  return {{scanner,
           {.strategy = pcmp(steps), .axis = axis, .light = light},
           {.phase_method = method, .cue_rule = rule}},
          {}};
}

TEST(PcmpScans, ComeOutAtTheirTrueDepth) {
  const Scanner scanner = example_scanner({160, 120});
  for (const int steps : {3, 4, 5, 6}) {
    for (const Axis axis : {Axis::x, Axis::y}) {
      const VirtualScan scan =
          scan_of_scene("boxes", scanner, pattern_set(pcmp(steps), axis, light),
                        {.ambient = ambient, .bits = std::nullopt});
      for (const PhaseMethod method :
           {PhaseMethod::equation, PhaseMethod::closed_form, PhaseMethod::tables}) {
        for (const CueRule rule : {CueRule::published, CueRule::consensus}) {
          const BasicCloud<double> cloud =
              engine(scanner, steps, axis, rule, method)(scan.frames).cloud;
          std::size_t points = 0, lit = 0;
          for (std::size_t i = 0; i < scan.depth.pixel_count(); ++i) {
            if (!std::isnan(scan.coordinate.begin()[i])) ++lit;
            if (std::isnan(cloud.z.begin()[i])) continue;
            ++points;
            ASSERT_NEAR(cloud.z.begin()[i], scan.depth.begin()[i], 1e-6)
                << steps << " steps, " << name_of(method) << ", " << name_of(rule);
          }
          EXPECT_EQ(points, lit);
        }
      }
    }
  }
}

struct Counts {
  std::size_t points = 0;
  std::size_t wrong = 0;
};

Counts noisy_statue(int steps, CueRule rule, int bits) {
  const Scanner scanner = example_scanner({640, 480});
  const VirtualScan scan =
      scan_of_scene("statue", scanner, pattern_set(pcmp(steps), Axis::x, light),
                    {.ambient = ambient, .noise_variance = 1.55, .bits = bits});
  const ReferenceResult made = engine(scanner, steps, Axis::x, rule)(scan.frames);
  Counts counts;
  for (std::size_t i = 0; i < scan.depth.pixel_count(); ++i) {
    if (made.cloud.validity.begin()[i] != Validity::valid) continue;
    ++counts.points;
    const double error = made.maps.coordinate.begin()[i] - scan.coordinate.begin()[i];
    if (!(std::abs(error) < 0.5 / pcmp(steps).f_h())) ++counts.wrong;
  }
  return counts;
}

TEST(PcmpScans, ShowNoPointOfAWrongFringeOrder) {
  for (const int steps : {3, 4, 5}) {
    const Counts consensus = noisy_statue(steps, CueRule::consensus, 8);
    const Counts published = noisy_statue(steps, CueRule::published, 8);
    EXPECT_EQ(consensus.wrong, 0U) << steps << " steps, of " << consensus.points;
    EXPECT_GE(consensus.points, published.points - published.wrong) << steps << " steps";
  }
}

TEST(PcmpScans, DecodeSixteenBitFrames) {
  const Counts counts = noisy_statue(3, CueRule::consensus, 12);
  EXPECT_GT(counts.points, 100000U);
  EXPECT_EQ(counts.wrong, 0U);
}

}  // namespace slipstream::pcmp_scans_test
