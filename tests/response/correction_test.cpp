#include "response/correction.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "decode/phase_decoder.h"
#include "paper/formulas.h"
#include "slipstream/error.h"
#include "slipstream/frame_set.h"
#include "slipstream/gray_code.h"
#include "slipstream/strategy.h"

namespace slipstream::correction_test {

using std::numbers::pi;

double wrapped(double angle) {
  const double turns = angle / (2 * pi);
  return std::min(2 * pi * (turns - std::floor(turns)), std::nextafter(2 * pi, 0));
}

TEST(Correction, TruePhaseUndoesTheDistortion) {
  rc::check([] {
    const int steps = *rc::gen::inRange(3, 12);
    // Past gamma 4.5 three steps measure one phase for a range of true ones, to rounding.
    const double gamma = *rc::gen::inRange(50, steps == 3 ? 450 : 1100) / 100.0;
    const double phi = *rc::gen::inRange(-10000, 10000) / 1000.0;
    const Response response = PowerLaw{gamma};
    const double measured = distorted_phase(response, steps, phi);
    RC_ASSERT(std::abs(true_phase(response, steps, measured) - phi) < 1e-9);
  });
}

TEST(Correction, PhaseCorrectionLeavesLessThanAMillionthOfARadian) {
  for (const int steps : {3, 4, 5, 6, 8}) {
    for (const double gamma : {0.7, 1.4, 2.21, 3.18, 4.42}) {
      const Response response = PowerLaw{gamma};
      const PhaseCorrection correction = phase_correction(response, steps);
      for (double phi = 0.0005; phi < 2 * pi; phi += 0.001) {
        const double measured = wrapped(distorted_phase(response, steps, phi));
        const double error = std::remainder(corrected_phase(correction, measured) - phi, 2 * pi);
        ASSERT_NEAR(error, 0, 1e-6) << "N " << steps << ", gamma " << gamma << ", phi " << phi;
      }
    }
  }
}

TEST(Correction, PhaseCorrectionIsFoundForAnyShifts) {
  for (const Strategy& strategy :
       {Strategy(PhaseMeasuring{.angles = {0, 90, 180, 270, 360}}),
        Strategy(DualFrequency{.shifts = {2.1, true}, .angles = {0, 45, 120, 200, 310}}),
        Strategy(GrayPhase{.periods = 8, .angles = {0, 60, 180, 250}}), Strategy(DoubleThreeStep{}),
        Strategy(TwoPlusOne{})}) {
    const Response response = PowerLaw{1.6};
    const PhaseCorrections corrections = phase_corrections(response, strategy.layout());
    ASSERT_EQ(corrections.size(), 1U) << strategy.name();
    const Band& band = strategy.layout().bands.front();
    double before = 0;
    for (double y = 0; y < 1 / band.periods; y += 0.003 / band.periods) {
      double C = 0, S = 0;
      for (int n = 0; n < frame_count(strategy); ++n) {
        const double light = light_at(response, strategy.shape(n, y));
        C += band.cosine[static_cast<std::size_t>(n)] * light;
        S += band.sine[static_cast<std::size_t>(n)] * light;
      }
      const double phi = 2 * pi * band.periods * y, measured = wrapped(std::atan2(S, C));
      before = std::max(before, std::abs(std::remainder(measured - phi, 2 * pi)));
      const double corrected = corrected_phase(corrections.at(1), measured);
      ASSERT_NEAR(std::remainder(corrected - phi, 2 * pi), 0, 1e-5) << strategy.name();
    }
    EXPECT_GT(before, 5e-4) << strategy.name();  // double-three-step: 0.001
  }
}

TEST(Correction, PhaseCorrectionIsNoneForFramesOfSeveralSinusoids) {
  for (const Strategy& strategy : {Strategy(TwoFrequency2N{}), Strategy(TwoFrequency4N{}),
                                   Strategy(GrayCode{}), Strategy(FourierProfilometry{})}) {
    EXPECT_TRUE(phase_corrections(PowerLaw{1.6}, strategy.layout()).empty()) << strategy.name();
  }
}

TEST(Correction, PhaseCorrectionTakesAMeasuredCurveToo) {
  // No power law: a straight line and a cube in equal parts.
  std::vector<double> values, intensities;
  for (int i = 0; i <= 64; ++i) {
    const double value = i / 64.0;
    values.push_back(value);
    intensities.push_back(10 + 100 * (value + value * value * value));
  }
  const PhaseCorrection correction = phase_correction(response_curve(values, intensities), 3);
  double before = 0, after = 0;
  for (double phi = 0; phi < 2 * pi; phi += 0.001) {
    double S = 0, C = 0;
    for (int n = 0; n < 3; ++n) {
      const double value = 0.5 + 0.5 * std::cos(phi - 2 * pi * n / 3);
      S += (value + value * value * value) * std::sin(2 * pi * n / 3);
      C += (value + value * value * value) * std::cos(2 * pi * n / 3);
    }
    const double measured = wrapped(std::atan2(S, C));
    before = std::max(before, std::abs(std::remainder(measured - phi, 2 * pi)));
    after = std::max(after,
                     std::abs(std::remainder(corrected_phase(correction, measured) - phi, 2 * pi)));
  }
  EXPECT_GT(before, 0.1);
  EXPECT_LT(after, 1e-4);
}

TEST(Correction, PhaseCorrectionIsNoneWithoutDistortion) {
  for (const double added : phase_correction(PowerLaw{1}, 3).added) EXPECT_NEAR(added, 0, 1e-12);
}

TEST(Correction, PhaseCorrectionIsShortWhereThatSuffices) {
  EXPECT_EQ(phase_correction(PowerLaw{1}, 3).added.size(), 256U);
  EXPECT_LE(phase_correction(PowerLaw{2.2}, 3).added.size(), 8192U);
}

TEST(Correction, PhaseCorrectionsAreOneForEachN) {
  const std::vector<Sinusoid> runs{{.steps = 4}, {.steps = 3}, {.steps = 4}};
  const PhaseCorrections corrections =
      phase_corrections(PowerLaw{2.2}, layout_of(runs, Unwrapping::none));
  EXPECT_EQ(corrections.size(), 2U);
  EXPECT_EQ(corrections.at(3).steps, 3);
  EXPECT_EQ(corrections.at(4).steps, 4);
}

TEST(Correction, PhaseCorrectionRefusesWhatItDoesNotModel) {
  EXPECT_THROW((void)phase_correction(PowerLaw{0.4}, 3), Error);
  EXPECT_THROW((void)phase_correction(PowerLaw{12}, 3), Error);
  EXPECT_THROW((void)phase_correction(PowerLaw{2}, 2), Error);
}

TEST(Correction, PrecompensationGivesTheLightThatWasMeant) {
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

TEST(Correction, DoubleThreeStepCancelsTheLargestPartOfTheError) {
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

}  // namespace slipstream::correction_test
