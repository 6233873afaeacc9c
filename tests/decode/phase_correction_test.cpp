#include "slipstream/decode/phase_correction.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>

#include "slipstream/base/error.h"

namespace slipstream::phase_correction_test {

constexpr double two_pi = 2 * std::numbers::pi;

PhaseCorrection of_sine(int steps, double amplitude) {
  PhaseCorrection correction{steps, {}};
  constexpr int count = 4096;
  for (int i = 0; i < count; ++i)
    correction.added.push_back(amplitude * std::sin(two_pi * i / count));
  return correction;
}

TEST(PhaseCorrection, RepeatsNTimesAroundTheCircle) {
  for (const int steps : {3, 4, 5, 6}) {
    const PhaseCorrection correction = of_sine(steps, 0.1);
    for (double phi = 0.2; phi < two_pi - 0.2; phi += 0.001) {
      EXPECT_NEAR(corrected_phase(correction, phi), phi + 0.1 * std::sin(steps * phi), 1e-7);
    }
  }
}

TEST(PhaseCorrection, StaysOnTheCircle) {
  const PhaseCorrection up{3, {0.1}};
  const PhaseCorrection down{3, {-0.1}};
  EXPECT_NEAR(corrected_phase(up, two_pi - 0.05), 0.05, 1e-12);
  EXPECT_NEAR(corrected_phase(down, 0.05), two_pi - 0.05, 1e-12);
  EXPECT_LT(corrected_phase({4, {-1e-18}}, 0), two_pi);
}

TEST(PhaseCorrection, IsRefusedWhereItIsNone) {
  EXPECT_NO_THROW(require_valid(PhaseCorrection{3, {0}}, 3));
  EXPECT_THROW(require_valid(PhaseCorrection{3, {}}, 3), Error);
  EXPECT_THROW(require_valid(PhaseCorrection{3, {0}}, 4), Error);
  EXPECT_THROW(require_valid(PhaseCorrection{2, {0}}, 2), Error);
  EXPECT_THROW(require_valid(PhaseCorrection{3, {std::numeric_limits<double>::infinity()}}, 3),
               Error);
}

}  // namespace slipstream::phase_correction_test
