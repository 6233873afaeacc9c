#include "check/waveform.h"

#include <cmath>
#include <complex>
#include <optional>
#include <string>

#include <gtest/gtest.h>

#include "check/frame_model.h"
#include "check/judged_scan.h"
#include "check/scan_samples.h"
#include "slipstream/check.h"
#include "slipstream/strategy.h"
#include "tests/check/mistakes.h"
#include "tests/check/scene_scan.h"

namespace slipstream::waveform_test {

std::optional<Waveform> found_in(const Scan& scan) {
  const FrameModel model(scan.sequence, scan.scanner->photometry);
  const FrameViews frames = scan.frames;
  ScanSamples samples(frames.size(), frames.count());
  samples.take(frames, {});

  const CheckSettings settings;
  return waveform_of(
      model, {model, samples, scan.sequence, &*scan.scanner, scan.scanner->photometry, settings},
      model.identity());
}

TEST(Waveform, ExplainsAResidualIfItLeavesAThird) {
  EXPECT_TRUE(Waveform{.residual = 0.3}.explains(1));
  EXPECT_FALSE(Waveform{.residual = 0.5}.explains(1));
}

// ((1 + cos a) / 2)^gamma has a second harmonic of (gamma - 1) / (gamma + 2) of the first.
TEST(Waveform, OfAPowerHasItsHarmonics) {
  for (const double gamma : {0.7, 1.6, 2.2, 3.0}) {
    for (const int steps : {5, 6, 8, 12}) {
      const auto waveform = found_in(scene_scan(
          "statue", make_strategy("dual-frequency", {{"steps", steps}}), PowerLaw{gamma}));

      ASSERT_TRUE(waveform);
      EXPECT_NEAR(waveform->harmonics[2].real(), (gamma - 1) / (gamma + 2), 0.03)
          << gamma << ", " << steps;
      EXPECT_NEAR(waveform->harmonics[2].imag(), 0, 0.03) << gamma << ", " << steps;
      EXPECT_LT(waveform->residual, 0.05) << gamma << ", " << steps;
      EXPECT_FALSE(waveform->is_odd()) << gamma << ", " << steps;
    }
  }
}

TEST(Waveform, OfStripesIsOdd) {
  const auto waveform = found_in(
      scene_scan("statue", make_strategy("gray-phase", {{"steps", 12}}), PowerLaw{1}, true));
  ASSERT_TRUE(waveform);
  EXPECT_TRUE(waveform->is_odd());
  EXPECT_LT(waveform->phase_error, 0.08);
}

// Four steps and more let so little of a gamma pass that noise hides it.
TEST(Waveform, IsNoFindingWhereItHardlyBendsThePhase) {
  for (const double gamma : {1.6, 1.9, 2.2}) {
    for (const int steps : {4, 5, 6, 8, 12}) {
      for (const char* const name : {"dual-frequency", "gray-phase", "multi-frequency"}) {
        const Scan scan =
            scene_scan("statue", make_strategy(name, {{"steps", steps}}), PowerLaw{gamma});
        EXPECT_EQ(told(check_scan(scan)), "")
            << name << ", gamma " << gamma << ", " << steps << " steps";
      }
    }
  }
}

// It is of the light alone: what frames in a wrong order leave stays.
TEST(Waveform, ExplainsNoOtherMistake) {
  for (const int steps : {4, 6}) {
    Scan scan =
        scene_scan("statue", make_strategy("dual-frequency", {{"steps", steps}}), PowerLaw{2.2});
    std::vector<int> order(static_cast<std::size_t>(scan.frames.count()));
    for (int n = 0; n < scan.frames.count(); ++n) order[static_cast<std::size_t>(n)] = n;
    std::swap(order[1], order[2]);
    taken_in_order(order)(scan);

    const std::vector<Finding> findings = check_scan(scan).findings;
    ASSERT_TRUE(any_wrong(findings)) << told(check_scan(scan));
    EXPECT_TRUE(blames(findings.front(), CauseKind::frame_order)) << told(check_scan(scan));
  }
}

}  // namespace slipstream::waveform_test
