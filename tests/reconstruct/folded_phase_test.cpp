// Corrections folded into the arctangent.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "decode/phase_decoder.h"
#include "reconstruct/fused/band_stage.h"
#include "reconstruct/fused/sinusoid_rows.h"
#include "response/correction.h"

namespace slipstream::folded_phase_test {

/// The corrected phase, rad, of a measured one from 0 to T.
double folded(const FoldedPhase& phase, double tangent, double measured) {
  const double v = std::tan(measured) / tangent, b = phase.b;
  const double x = (1 - (2 + b) * v) / (1 + b * v);
  double turns = 0;
  for (const float c : phase.coefficients) turns = turns * x + c;
  return 2 * std::numbers::pi * turns;
}

TEST(FoldedPhase, IsTheTruePhase) {
  using std::numbers::pi;
  for (const int steps : {3, 4, 6}) {
    const double end = steps == 4 ? pi / 4 : pi / 3, tangent = std::tan(end);
    for (const double gamma : {0.7, 1.0, 1.8, 2.2, 3.0}) {
      const Response response(PowerLaw{gamma});
      const FoldedPhase phase = folded_phase(phase_correction(response, steps));
      ASSERT_FALSE(phase.empty()) << steps << " steps, gamma " << gamma;
      for (int i = 0; i <= 100; ++i) {
        const double measured = end * i / 100;
        ASSERT_NEAR(folded(phase, tangent, measured), true_phase(response, steps, measured), 1.2e-6)
            << steps << " steps, gamma " << gamma << ", at " << measured;
      }
    }
  }
}

TEST(FoldedPhase, TakesFewTerms) {
  const auto degree = [](double gamma, int steps) {
    return folded_phase(phase_correction(PowerLaw{gamma}, steps)).coefficients.size() - 1;
  };
  EXPECT_LE(degree(2.2, 3), 12U);
  EXPECT_LE(degree(2.2, 4), 8U);
  EXPECT_LE(degree(2.2, 6), 10U);
}

TEST(FoldedPhase, IsForOddCorrectionsOfThreeFourAndSixSteps) {
  EXPECT_TRUE(folded_phase(phase_correction(PowerLaw{2.2}, 5)).empty());
  PhaseCorrection lopsided = phase_correction(PowerLaw{2.2}, 3);
  for (double& added : lopsided.added) added += 1e-5;
  EXPECT_TRUE(folded_phase(lopsided).empty());
}

}  // namespace slipstream::folded_phase_test
