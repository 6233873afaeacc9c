#include "slipstream/gamma.h"

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <ostream>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "base/statistics.h"
#include "decode/phase_decoder.h"
#include "paper/board_experiment.h"
#include "response/correction.h"
#include "response/gamma_calibration.h"
#include "response/harmonics.h"
#include "response/response_fit.h"
#include "slipstream/error.h"
#include "slipstream/frame_set.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/sequence.h"
#include "slipstream/strategy.h"

namespace slipstream {

void PrintTo(BlindRefusal refusal, std::ostream* stream) {
  *stream << reason_of(refusal);
}

namespace {

using std::numbers::pi;

/// Traced once for all tests.
const BoardExperiment& white_board() {
  static const BoardExperiment board({160, 120});
  return board;
}
const BoardExperiment& textured_board() {
  static const BoardExperiment board({160, 120}, BoardExperiment::Surface::textured);
  return board;
}

/// A row of pixels all around the circle, as a projector of that response shows them.
Image<MeasuredHarmonics> full_circle(const Response& response, int steps, double brightness = 200,
                                     double ambient = 0) {
  Image<MeasuredHarmonics> pixels({4000, 1});
  for (int i = 0; i < pixels.width(); ++i) {
    MeasuredHarmonics& pixel = pixels(i, 0);
    pixel = measured_harmonics(response, steps, 2 * pi * i / pixels.width());
    pixel.mean = brightness * pixel.mean + ambient;
    pixel.fundamental *= brightness;
    pixel.second *= brightness;
    pixel.third *= brightness;
  }
  return pixels;
}

Image<std::uint8_t> all_lit(const Image<MeasuredHarmonics>& pixels) {
  return Image<std::uint8_t>(pixels.size(), 1);
}

TEST(Gamma, BlindGammaWithoutNoiseIsExact) {
  for (const auto& [steps, gamma] : {std::pair{3, 3.18}, {4, 6.36}, {5, 10.36}, {3, 2.21}}) {
    const Image<MeasuredHarmonics> pixels = full_circle(PowerLaw{gamma}, steps);
    const BlindGamma found = find_gamma(pixels, all_lit(pixels), steps);
    EXPECT_EQ(found.refusal, BlindRefusal::none);
    EXPECT_NEAR(found.gamma, gamma, 1e-6);

    const PhaseCorrection correction = phase_correction(PowerLaw{found.gamma}, steps);
    double sum = 0;
    for (int i = 0; i < pixels.width(); ++i) {
      const double measured = std::arg(pixels(i, 0).fundamental);
      const double phi = corrected_phase(correction, measured < 0 ? measured + 2 * pi : measured);
      const double error = std::remainder(phi - 2 * pi * i / pixels.width(), 2 * pi);
      sum += error * error;
    }
    EXPECT_LE(std::sqrt(sum / pixels.width()), 1e-6) << "N " << steps;
  }
}

TEST(Gamma, BlindGammaIsFoundForOtherNAndBelow1) {
  for (const auto& [steps, gamma] : {std::pair{6, 0.7}, {8, 1.5}, {4, 1.3}, {7, 2.2}}) {
    const Image<MeasuredHarmonics> pixels = full_circle(PowerLaw{gamma}, steps);
    const BlindGamma found = find_gamma(pixels, all_lit(pixels), steps);
    EXPECT_EQ(found.refusal, BlindRefusal::none);
    EXPECT_NEAR(found.gamma, gamma, 1e-6);
  }
}

TEST(Gamma, BlindGammaOfFewPixelsIsFoundOrRefused) {
  for (const int width : {100, 130, 500}) {
    Image<MeasuredHarmonics> pixels({width, 1});
    for (int i = 0; i < width; ++i) {
      pixels(i, 0) = measured_harmonics(PowerLaw{2.2}, 6, 2 * pi * i / width);
    }
    const BlindGamma found = find_gamma(pixels, all_lit(pixels), 6);
    EXPECT_TRUE(found.accepted());
    EXPECT_NEAR(found.gamma, 2.2, 1e-6);
    for (MeasuredHarmonics& pixel : pixels) pixel.second = -pixel.second;
    EXPECT_EQ(find_gamma(pixels, all_lit(pixels), 6).refusal, BlindRefusal::no_power_law);
  }
}

TEST(Gamma, BlindGammaRefusesWhereTheDataDoNotSay) {
  const auto refusal = [](const Image<MeasuredHarmonics>& pixels, int steps) {
    return find_gamma(pixels, all_lit(pixels), steps).refusal;
  };
  EXPECT_EQ(refusal(full_circle(PowerLaw{2.2}, 3, 200, 5), 3), BlindRefusal::ambient_light);
  EXPECT_EQ(refusal(full_circle(PowerLaw{1}, 3, 200, 5), 3), BlindRefusal::ambient_light);
  EXPECT_EQ(refusal(full_circle(PowerLaw{1}, 3), 3), BlindRefusal::no_distortion);
  EXPECT_EQ(refusal(full_circle(PowerLaw{1}, 4, 200, 5), 4), BlindRefusal::no_distortion);
  EXPECT_EQ(refusal(full_circle(PowerLaw{1}, 5, 200, 5), 5), BlindRefusal::no_distortion);

  // An S: dark and bright are pressed together, as no power law does.
  std::vector<double> values, intensities;
  for (int i = 0; i <= 32; ++i) {
    values.push_back(i / 32.0);
    intensities.push_back(-std::cos(pi * i / 32.0));
  }
  const Response s_curve = response_curve(values, intensities);
  // It has no even harmonics; four steps see the others in the mean alone.
  for (const int steps : {4, 5, 6, 8}) {
    EXPECT_EQ(refusal(full_circle(s_curve, steps), steps), BlindRefusal::no_power_law) << steps;
  }
  const Image<MeasuredHarmonics> pixels = full_circle(PowerLaw{2.2}, 4);
  EXPECT_EQ(find_gamma(pixels, Image<std::uint8_t>(pixels.size()), 4).refusal,
            BlindRefusal::too_few_pixels);
}

/// Blind gamma of two sinusoids of eight steps. `show`: light, 0 to 1, of the sinusoid 0 or 1 where
/// a pattern has a value; `noise`: of each, in grey levels.
template <class Show>
BlindGamma blind_gamma_of_two(const std::array<double, 2>& noise, const Show& show) {
  const Sequence sequence{.strategy = DualFrequency{.steps = 8}};
  const PatternSet patterns = pattern_set(sequence);
  std::mt19937 random(1);
  std::normal_distribution<double> deviation;

  FrameSet::Images8 frames;
  for (int n = 0; n < patterns.count; ++n) {
    const std::size_t sinusoid = n < 8 ? 0 : 1;
    Image<std::uint8_t>& frame = frames.emplace_back(Size{160, 90});
    for (std::size_t i = 0; i < frame.pixel_count(); ++i) {
      const double light = show(sinusoid, patterns.shape(n, static_cast<double>(i % 160) / 160, 0));
      const double grey = 30 + 190 * light + noise[sinusoid] * deviation(random);
      frame.begin()[i] = static_cast<std::uint8_t>(std::lround(grey));
    }
  }
  return choose_gamma("blind", {}, sequence.strategy.layout(), FrameSet(std::move(frames)))
      .blind.value();
}

TEST(Gamma, BlindGammaIsThatOfTheSurerSinusoidInEitherOrder) {
  const auto shown = [](std::size_t, double value) { return std::pow(value, 2.2); };
  const double unsure = blind_gamma_of_two({2, 2}, shown).standard_error;
  for (const std::array<double, 2> noise : {std::array{2.0, 0.5}, std::array{0.5, 2.0}}) {
    const BlindGamma found = blind_gamma_of_two(noise, shown);
    EXPECT_TRUE(found.accepted()) << reason_of(found.refusal);
    EXPECT_LT(found.standard_error, 0.5 * unsure);
  }
}

TEST(Gamma, BlindGammaIsRefusedIfOneSinusoidFollowsNoPowerLaw) {
  for (const std::size_t wrong : {0U, 1U}) {
    const BlindGamma found = blind_gamma_of_two({1, 1}, [&](std::size_t sinusoid, double value) {
      return sinusoid == wrong ? 0.5 - 0.5 * std::cos(pi * value) : std::pow(value, 2.2);
    });
    EXPECT_EQ(found.refusal, BlindRefusal::no_power_law) << wrong;
  }
}

struct Experiment {
  int steps;
  double gamma;
  double ambient;  ///< none for N = 3, as the paper has it
  double published_before;
  double calibrated_gain;  ///< least
  double blind_gain;       ///< least
};

class GammaSection45 : public testing::TestWithParam<Experiment> {};

TEST_P(GammaSection45, IsAtLeastAsPublished) {
  const auto& [steps, gamma, ambient, published, calibrated_gain, blind_gain] = GetParam();
  const FrameSet frames = white_board().averaged(steps, gamma, ambient);
  const Image<MeasuredHarmonics> pixels = pixel_harmonics(frames, 0, steps);
  const Image<std::uint8_t> lit = well_lit(pixels, frames);
  const auto rms_with = [&](double corrected_for) {
    return white_board().rms_error(
        frames, {{steps, phase_correction(PowerLaw{corrected_for}, steps)}}, lit);
  };
  const double before = white_board().rms_error(frames, {}, lit);
  EXPECT_NEAR(before / published, 1, 0.03);
  EXPECT_GE(before / rms_with(gamma), calibrated_gain);

  const BlindGamma found = find_gamma(pixels, lit, steps);
  ASSERT_TRUE(found.accepted()) << reason_of(found.refusal);
  EXPECT_GE(before / rms_with(found.gamma), blind_gain);
}

INSTANTIATE_TEST_SUITE_P(Board, GammaSection45,
                         testing::Values(Experiment{3, 2.21, 0, 0.0256, 60, 33},
                                         Experiment{4, 4.42, 5, 0.0152, 43, 43},
                                         Experiment{5, 7.73, 5, 0.0123, 39, 39}),
                         [](const auto& info) { return "N" + std::to_string(info.param.steps); });

TEST(Gamma, BlindGammaOfOneNoisyTexturedScanIsNearTheTruth) {
  for (const auto& [steps, gamma] : {std::pair{4, 2.21}, {5, 2.21}, {6, 1.4}}) {
    const BlindGamma found = find_gamma(textured_board().once(steps, gamma, 5), 0, steps);
    EXPECT_EQ(found.refusal, BlindRefusal::none);
    EXPECT_NEAR(found.gamma, gamma, 0.01);
  }
}

TEST(Gamma, BlindGammaSeesAmbientLightInNoise) {
  for (const double gamma : {1.0, 2.21}) {
    const BlindGamma found = find_gamma(textured_board().once(3, gamma, 5), 0, 3);
    EXPECT_EQ(found.refusal, BlindRefusal::ambient_light) << found.gamma;
    EXPECT_FALSE(found.accepted());
  }
}

GammaEstimate measured(const BoardExperiment& board, double gamma) {
  constexpr int steps = 20;
  const FrameSet frames = board.averaged(steps, gamma, 5, 4);
  const Image<MeasuredHarmonics> pixels = pixel_harmonics(frames, 0, steps);
  return robust_gamma(gamma_map(pixels, well_lit(pixels, frames)));
}

TEST(Gamma, MeasuredGammaOfATexturedObjectIsThatOfTheWhiteBoard) {
  for (const double gamma : {2.21, 4.42, 7.73}) {
    const GammaEstimate white = measured(white_board(), gamma);
    const GammaEstimate veined = measured(textured_board(), gamma);
    EXPECT_NEAR(veined.gamma, gamma, 0.005);
    EXPECT_NEAR(veined.gamma, white.gamma, 0.005);
    EXPECT_LT(veined.standard_error, 0.002);
  }
}

TEST(Gamma, RobustGammaHasTheStandardErrorItSays) {
  // Gaussian pixels by a sum of 12 uniform ones; 200 maps, one gamma each.
  std::uint32_t state = 7;
  const auto uniform = [&] {
    state = state * 1664525U + 1013904223U;
    return state / 4294967296.0;
  };
  constexpr int maps = 200;
  double squares = 0, promised = 0;
  for (int i = 0; i < maps; ++i) {
    Image<double> map({20, 20});
    for (double& pixel : map) {
      pixel = -6;
      for (int k = 0; k < 12; ++k) pixel += uniform();
      pixel = 2.2 + 0.1 * pixel;
    }
    map(0, 0) = 1000;
    map(1, 0) = std::numeric_limits<double>::quiet_NaN();
    const GammaEstimate estimate = robust_gamma(map);
    squares += (estimate.gamma - 2.2) * (estimate.gamma - 2.2);
    promised += estimate.standard_error;
  }
  EXPECT_NEAR(std::sqrt(squares / maps) / (promised / maps), 1, 0.25);
}

TEST(Gamma, RobustGammaRefusesAMapWithHardlyAnyPixel) {
  Image<double> map({20, 20}, std::numeric_limits<double>::quiet_NaN());
  for (int i = 0; i < 20; ++i) map(i, 0) = 2;
  EXPECT_THROW((void)robust_gamma(map), Error);
}

TEST(Gamma, HistogramCountsWhatIsInside) {
  Image<double> map({4, 1});
  map(0, 0) = 1.1;
  map(1, 0) = 1.9;
  map(2, 0) = 2;
  map(3, 0) = std::numeric_limits<double>::quiet_NaN();
  const Histogram counted = histogram(map, 1, 2, 2);
  EXPECT_EQ(counted.counts, (std::vector<std::size_t>{1, 1}));
}

TEST(Gamma, FitGammaFindsTheCurveItIsGiven) {
  rc::check([] {
    const double gamma = *rc::gen::inRange(50, 1100) / 100.0;
    const double offset = *rc::gen::inRange(-50, 200) / 10.0;
    std::vector<double> values, intensities;
    for (int i = 0; i <= 17; ++i) {
      values.push_back(i / 17.0);
      intensities.push_back(offset + 180 * std::pow(values.back(), gamma));
    }
    const GammaFit fit = fit_gamma(values, intensities);
    RC_ASSERT(std::abs(fit.gamma - gamma) < 1e-4 * gamma);
    RC_ASSERT(std::abs(fit.offset - offset) < 1e-2);
    RC_ASSERT(fit.rms < 1e-2);
  });
}

TEST(Gamma, FitGammaRefusesWhatSaysNothing) {
  const std::vector<double> same(6, 0.5), rising{0, 0.2, 0.4, 0.6, 0.8, 1};
  const std::vector<double> falling{6, 5, 4, 3, 2, 1};
  EXPECT_THROW((void)fit_gamma(same, rising), Error);
  EXPECT_THROW((void)fit_gamma(rising, falling), Error);
  EXPECT_THROW((void)fit_gamma(std::vector{0.0, 0.5, 1.0}, std::vector{1.0, 2.0, 3.0}), Error);
}

}  // namespace
}  // namespace slipstream
