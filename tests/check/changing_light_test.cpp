#include "check/changing_light.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/check.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"
#include "tests/check/mistakes.h"
#include "tests/check/scene_scan.h"
#include "tests/geometry/random_scanner.h"

namespace slipstream::changing_light_test {

/// Gives frame n that gain; frames beyond the list are unchanged.
Scan with_gains(Scan scan, const std::vector<double>& gains) {
  const int count = std::min(scan.frames.count(), static_cast<int>(gains.size()));
  for (int n = 0; n < count; ++n) {
    const double gain = gains[static_cast<std::size_t>(n)];
    pixels({n}, [gain](double level, int, int) { return gain * level; })(scan);
  }
  return scan;
}

Scan with_gain(Scan scan, int frame, double gain) {
  pixels({frame}, [gain](double level, int, int) { return gain * level; })(scan);
  return scan;
}

/// The finding about light, or one of another kind.
Finding light_of(const Scan& scan, std::string& told, const CheckSettings& settings = {}) {
  Finding found;
  for (const Finding& finding : check_scan(scan, settings).findings) {
    told += text_of(finding) + "\n";
    if (finding.kind == FindingKind::changing_light) found = finding;
  }
  return found;
}

TEST(ChangingLight, ChangedLightOfOneFrameIsToldBySize) {
  for (const Strategy& strategy :
       {make_strategy("dual-frequency", {{"steps", 4}}), make_strategy("pmp", {{"steps", 4}}),
        make_strategy("gray-phase", {{"steps", 4}}), make_strategy("micro", {}),
        make_strategy("pcmp", {})}) {
    const Scan right = scene_scan("statue", strategy);

    for (const double gain : {0.9, 0.95}) {
      for (const int frame : {0, 2}) {
        std::string told;
        const Finding light = light_of(with_gain(right, frame, gain), told);

        EXPECT_EQ(light.kind, FindingKind::changing_light)
            << label_of(strategy) << ", frame " << frame << ", " << gain << ": " << told;
        EXPECT_EQ(light.frames, std::vector<int>{frame}) << label_of(strategy) << ": " << told;
        ASSERT_FALSE(light.evidence.empty()) << label_of(strategy);
        EXPECT_NEAR(light.evidence.front().value, 100 * (gain - 1), 2.5) << label_of(strategy);
      }
    }
  }
}

// An automatic exposure changes every frame, by more than lamps do.
TEST(ChangingLight, ChangedLightOfAllFramesIsNotBlamedOnThePatterns) {
  const std::vector<double> gains{1, 0.6, 0.9, 0.5, 0.8, 0.7, 0.95, 0.55, 0.85};
  for (const Strategy& strategy :
       {make_strategy("dual-frequency", {{"steps", 4}}),
        make_strategy("dual-frequency", {{"steps", 3}}), make_strategy("pmp", {{"steps", 4}}),
        make_strategy("multi-frequency", {})}) {
    std::string told;
    const Scan scan = with_gains(scene_scan("statue", strategy), gains);
    const Finding light = light_of(scan, told);

    EXPECT_EQ(light.kind, FindingKind::changing_light) << label_of(strategy) << ": " << told;
    EXPECT_EQ(light.severity, Severity::wrong) << label_of(strategy);
    EXPECT_EQ(told.find("gamma"), std::string::npos) << label_of(strategy) << ": " << told;
    EXPECT_NE(told.find("switch off automatic exposure"), std::string::npos) << told;

    // Where something moves, that looks the same.
    EXPECT_NE(light_of(scan, told, {.moving = true}).kind, FindingKind::changing_light) << told;
  }
}

TEST(ChangingLight, ChangedLightOfACodeIsAWarningAtMost) {
  const Scan right =
      scene_scan("statue", make_strategy("gray", {{"bits", 9}, {"reference", "inverse"}}));
  const std::vector<double> gains{1, 1, 0.6, 1, 0.9, 1, 0.6};
  const ScanFindings found = check_scan(with_gains(right, gains));

  ASSERT_EQ(found.findings.size(), 1U);
  EXPECT_EQ(found.findings.front().kind, FindingKind::changing_light);
  EXPECT_FALSE(any_wrong(found.findings));
}

// A rolling shutter sees flicker row by row: the mean of each frame hardly changes.
TEST(ChangingLight, FlickerByRowsIsTold) {
  for (const Strategy& strategy :
       {make_strategy("dual-frequency", {{"steps", 3}}), make_strategy("multi-frequency", {}),
        make_strategy("gray-phase", {{"steps", 4}})}) {
    Scan scan = scene_scan("statue", strategy);
    const int height = scan.frames.size().height;
    for (int n = 0; n < scan.frames.count(); ++n) {
      pixels({n}, [=](double level, int, int row) {
        return level * (1 + 0.08 * std::sin(2.1 * n + 9.0 * row / height));
      })(scan);
    }

    std::string told;
    EXPECT_EQ(light_of(scan, told).kind, FindingKind::changing_light)
        << label_of(strategy) << ": " << told;
    EXPECT_EQ(light_of(scan, told, {.moving = true}).kind, Finding{}.kind) << told;
  }
}

// Along y each strip of rows sees other places of the patterns. Blur makes them fainter, which
// looked like another gain in each strip.
TEST(ChangingLight, BlurredPatternsAlongYAreNotCalledFlicker) {
  int scans = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    VirtualWorld world{.scanner = random_scanner(seed, 0.1, {96, 72})};
    const Eigen::Vector3d& baseline = world.scanner.translation;
    if (std::abs(baseline.x()) > std::abs(baseline.y())) continue;

    world.scene = scene_named("board", world.scanner);
    world.photometry = photometry_named("bench,no-response");
    world.photometry.physics.bounces = 0;
    world.photometry.bits = 10;

    const Sequence sequence{.strategy = make_strategy("pcmp", {{"steps", 5}}),
                            .axis = Axis::y,
                            .projector = world.scanner.projector.size};
    Scan scan{.sequence = sequence, .scanner = as_calibrated(world)};
    scan.frames =
        take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry).frames;

    std::string told;
    EXPECT_NE(light_of(scan, told).kind, FindingKind::changing_light) << seed << ": " << told;
    ++scans;
  }
  EXPECT_GE(scans, 3);
}

// Bits that are darker than other frames as a whole are not mixed with the bit before.
TEST(ChangingLight, ChangedLightOfHalfOfTheFramesIsNotCalledOutOfStep) {
  const Scan right = scene_scan("statue", make_strategy("gray-phase", {{"steps", 4}}));
  std::vector<double> gains(static_cast<std::size_t>(right.frames.count()), 0.6);
  std::fill_n(gains.begin(), 5, 1.0);

  EXPECT_FALSE(any_wrong(check_scan(with_gains(right, gains)).findings));
}

}  // namespace slipstream::changing_light_test
