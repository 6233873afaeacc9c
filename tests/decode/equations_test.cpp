#include "slipstream/decode/equations.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/base/error.h"
#include "slipstream/codes/sinusoid.h"

namespace slipstream::equations_test {

using std::numbers::pi;

TEST(PhaseEquations, GiveBackMeanModulationAndPhaseForAnyN) {
  for (const int N : {3, 4, 5, 6, 7, 8, 16, 31}) {
    const PhaseEquations decode(N);
    for (double phi = 0; phi < 2 * pi; phi += 0.05) {
      std::vector<double> I;
      for (int n = 0; n < N; ++n) I.push_back(120 + 80 * std::cos(phi - 2 * pi * n / N));
      const PhaseSample sample = decode(I);
      EXPECT_NEAR(sample.mean, 120, 1e-10);
      EXPECT_NEAR(sample.modulation, 80, 1e-10);
      EXPECT_NEAR(sample.wrapped_phase, phi, 1e-12);
    }
  }
}

TEST(PhaseEquations, RefuseTooFewSteps) {
  EXPECT_THROW(PhaseEquations(2), Error);
}

TEST(WrappedAngle, StaysInTheCircleAndOffItsEnd) {
  EXPECT_EQ(wrapped_angle(-1e-14, 1), 0);
  EXPECT_EQ(wrapped_angle(0, 0), 0);
  EXPECT_NEAR(wrapped_angle(-1, 0), 1.5 * pi, 1e-15);
  EXPECT_NEAR(wrapped_angle(0, -1), pi, 1e-15);
  EXPECT_LT(wrapped_angle(-1e-9, 1), 2 * pi);
}

}  // namespace slipstream::equations_test
