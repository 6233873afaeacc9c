// What people do instead of correcting the phase.
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "slipstream/codes/registry.h"
#include "slipstream/frames/frame_set.h"
#include "slipstream/response/correction.h"
#include "slipstream/response/distortion.h"
#include "slipstream/response/double_three_step.h"
#include "slipstream/response/precompensation.h"

namespace slipstream::alternatives_test {

using std::numbers::pi;

TEST(Precompensation, GivesTheLightThatWasMeant) {
  const PatternSet meant =
      pattern_set(PhaseMeasuring{3, 1}, Axis::x, {.alpha_p = 200, .beta_p = 20});
  const Response response = PowerLaw{2.2};
  const PatternSet shown = precompensated(meant, response);
  for (int n = 0; n < 3; ++n) {
    for (double y = 0; y < 1; y += 0.01) {
      EXPECT_NEAR(255 * light_at(response, shown.intensity(n, y) / 255), meant.intensity(n, y),
                  1e-10);
    }
  }
}

TEST(DoubleThreeStep, CancelsTheLargestPartOfTheError) {
  FrameSet::ImagesUnquantised images(6, Image<double>({2000, 1}));
  for (int i = 0; i < 2000; ++i) {
    for (int n = 0; n < 6; ++n) {
      const double value = 0.5 + 0.5 * std::cos(2 * pi * i / 2000 - 2 * pi * n / 6);
      images[static_cast<std::size_t>(n)](i, 0) = 200 * std::pow(value, 2.2);
    }
  }
  const Image<double> phase = double_three_step_phase(FrameSet(images), 0);
  double sum = 0;
  for (int i = 0; i < 2000; ++i) {
    const double error = std::remainder(phase(i, 0) - 2 * pi * i / 2000, 2 * pi);
    sum += error * error;
  }
  const double rms = std::sqrt(sum / 2000);
  EXPECT_LT(rms, rms_phase_error(PowerLaw{2.2}, 3) / 7);
  // Six frames decoded together do better still, and so do three that are corrected.
  EXPECT_GT(rms, rms_phase_error(PowerLaw{2.2}, 6));
}

}  // namespace slipstream::alternatives_test
