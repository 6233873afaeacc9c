// Light and sensor as scans of the virtual scanner show them.
#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <gtest/gtest.h>

#include "response/ambient_calibration.h"
#include "response/gamma_calibration.h"
#include "response/noise_calibration.h"
#include "response/scan_average.h"
#include "slipstream/error.h"
#include "slipstream/gamma.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/io/expect_error.h"

namespace slipstream::photometry_test {

/// Brightest where gamma is to be told, dimmer where no frame may be clipped.
constexpr PatternLight bright{}, dim{.alpha_p = 200, .beta_p = 40};

Scan scan_of(const Strategy& strategy, const Photometry& photometry,
             const PatternLight& light = dim) {
  const Scanner scanner = example_scanner({128, 96});
  const Sequence sequence{.strategy = strategy, .light = light};
  return {
      .frames = take_scan(scanner, scene_named("board", scanner), pattern_set(sequence), photometry)
                    .frames,
      .sequence = sequence};
}

const Strategy six_steps = PhaseMeasuring{.steps = 6};

TEST(Photometry, ScanAverageTakesScansOfOneKind) {
  ScanAverage scans;
  scans.add(scan_of(six_steps, {}), "one");
  scans.add(scan_of(six_steps, {.seed = 2}), "two");
  EXPECT_EQ(scans.frames.count(), 2);

  // A pixel that one scan clips is clipped.
  ScanAverage clipped;
  clipped.add(scan_of(six_steps, {.ambient = 100}), "bright");
  clipped.add(scan_of(six_steps, {}), "one");
  EXPECT_LT(std::ranges::count(clipped.unclipped, 1), std::ranges::count(scans.unclipped, 1));
  expect_error([&] { scans.add(scan_of(PhaseMeasuring{.steps = 5}, {}), "three"); },
               {"three", "one"});
}

TEST(Photometry, AmbientCalibrationFindsTheAmbientLight) {
  ScanAverage scans;
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    scans.add(scan_of(six_steps, {.ambient = -5, .noise_variance = 2, .seed = seed}), "a scan");
  }
  EXPECT_NEAR(calibrate_ambient(scans).estimate.mode, -5, 0.2);
  const Sequence cued{.strategy = PhaseChannelMultiplexing{}};
  expect_error([&] { require_ambient_measurable({.sequence = cued}, "a cued scan"); },
               {"a cued scan"});
}

TEST(Photometry, AmbientCalibrationKnowsTheResponseOrRefuses) {
  for (const int steps : {4, 6, 12}) {
    for (const double gamma : {0.7, 1.3, 2.2}) {
      ScanAverage scans;
      scans.add(
          scan_of(PhaseMeasuring{.steps = steps},
                  {.ambient = 5, .response = PowerLaw{gamma}, .noise_variance = 2, .seed = 3}),
          "a scan");
      EXPECT_NEAR(calibrate_ambient(scans, 0.5, PowerLaw{gamma}).estimate.mode, 5, 0.3)
          << steps << " steps, gamma " << gamma;
      expect_error([&] { (void)calibrate_ambient(scans); },
                   {"not linear", "second harmonic", "calibrate_gamma()"});
      expect_error([&] { (void)calibrate_ambient(scans, 0.5, PowerLaw{1.7}); },
                   {"response in the scanner file", "calibrate gamma again"});
    }
  }
}

TEST(Photometry, ResponseLinearityIsTheSecondHarmonic) {
  // Four steps, which alias it, say the same of it as twelve.
  const double share = second_harmonic(dim, PowerLaw{1.3}, 12);
  EXPECT_NEAR(second_harmonic(dim, PowerLaw{1.3}, 4), share, 0.05 * share);

  for (const int steps : {4, 5, 8}) {
    const auto of = [&](double gamma) {
      ScanAverage scans;
      scans.add(scan_of(PhaseMeasuring{.steps = steps},
                        {.response = PowerLaw{gamma}, .noise_variance = 2, .seed = 5}, bright),
                "a scan");
      return response_linearity(scans).value();
    };
    EXPECT_TRUE(has_second_harmonic(of(1), 0)) << of(1).second;
    EXPECT_FALSE(has_second_harmonic(of(1.05), 0)) << of(1.05).second;
    EXPECT_TRUE(has_second_harmonic(of(2.2), second_harmonic(bright, PowerLaw{2.2}, steps)))
        << of(2.2).second;
    EXPECT_LT(of(1).standard_error, 0.001);
  }
  ScanAverage three;
  three.add(scan_of(PhaseMeasuring{.steps = 3}, {.response = PowerLaw{2}}), "a scan");
  EXPECT_FALSE(response_linearity(three));
}

TEST(Photometry, GammaCalibrationFindsGammaByEachPixelAndByAll) {
  ScanAverage scans;
  scans.add(scan_of(six_steps, {.response = PowerLaw{2.2}, .noise_variance = 0.2}, bright),
            "a scan");
  const GammaCalibration found = calibrate_gamma(scans);
  EXPECT_EQ(found.steps, 6);
  EXPECT_EQ(found.response.value().name, "power law");
  EXPECT_NEAR(found.pixels.value().estimate.gamma, 2.2, 0.01);
}

TEST(Photometry, GammaChoiceIsWhatIsAskedFor) {
  const MeasuredResponse known{PowerLaw{1.8}, 1.8, 0.01};
  EXPECT_EQ(choose_gamma("scanner", known).response, known);
  EXPECT_FALSE(choose_gamma("scanner", std::nullopt).response);
  EXPECT_FALSE(choose_gamma("none", known).response);
  EXPECT_EQ(choose_gamma("2.4", known).gamma, 2.4);
  expect_error([&] { (void)choose_gamma("bright", known); }, {"bright"});
  expect_error([&] { (void)choose_gamma("blind", known); }, {"scan"});
  const Scan scan = scan_of(six_steps, {.response = PowerLaw{2.2}}, bright);
  const GammaChoice blind =
      choose_gamma("blind", known, scan.sequence.strategy.layout(), scan.frames);
  EXPECT_EQ(blind.source, "blind");
  EXPECT_NEAR(blind.gamma.value(), 2.2, 0.05);
}

TEST(Photometry, NoiseCalibrationGivesTheVarianceByEveryEquationThatTheScansAllow) {
  const Photometry photometry{.noise_variance = 2};
  std::vector<NoiseScan> scans;
  for (std::uint64_t seed = 1; seed <= 2; ++seed) {
    Photometry noisy = photometry;
    noisy.seed = seed;
    scans.emplace_back(scan_of(PhaseMeasuring{.steps = 4}, noisy));
  }
  const auto found = calibrate_noise(scans);
  ASSERT_GE(found.size(), 2U);
  for (const NoiseMeasurement& measured : found) {
    EXPECT_NEAR(measured.variance, 2 + 1.0 / 12, 0.15) << measured.equation;
    EXPECT_EQ(measured.reason, "") << measured.equation;
  }
  // Three scans make three pairs.
  Photometry third = photometry;
  third.seed = 3;
  std::vector<NoiseScan> more = scans;
  more.emplace_back(scan_of(PhaseMeasuring{.steps = 4}, third));
  EXPECT_NEAR(calibrate_noise(more).front().standard_error,
              found.front().standard_error / std::sqrt(3), 0.1 * found.front().standard_error);
  scans.push_back(scans.front());
  expect_error([&] { (void)calibrate_noise(scans); }, {"identical frames", "`seed`"});
}

constexpr PatternLight light{.alpha_p = 200, .beta_p = 55};

TEST(Photometry, AmbientMeasurementSolvesEquation35AtBrightPixels) {
  const Size size{40, 30};
  Image<double> mean(size), modulation(size);
  Image<std::uint8_t> measured(size, 1);
  measured(3, 4) = 0;
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const double alpha = (column + 1.0) / size.width;
      const double beta = row == 0 ? 30 : -7;               // a row that sees a lamp
      modulation(column, row) = alpha * light.alpha_p / 2;  // (3.4)
      mean(column, row) = alpha * (light.alpha_p / 2 + light.beta_p + beta) + beta;  // (3.3)
    }
  }
  const Image<double> map = ambient_map(mean, modulation, light, 0.5, measured);
  EXPECT_TRUE(std::isnan(map(3, 4)));
  EXPECT_TRUE(std::isnan(map(10, 4)));
  EXPECT_NEAR(map(35, 4), -7, 1e-12);
  const AmbientEstimate estimate = ambient_estimate(map);
  EXPECT_NEAR(estimate.mode, -7, 1e-12);
  EXPECT_NEAR(estimate.median, -7, 1e-12);
  EXPECT_NEAR(estimate.mean, -7 + 37.0 / 30, 1e-9) << "the lamp draws the mean, not the mode";
  EXPECT_EQ(estimate.pixels, 21U * 30U);
  EXPECT_THROW(ambient_estimate(ambient_map(mean, modulation, light, 1, measured)), Error);
}

TEST(Photometry, AmbientEstimateIsTheFullestGreyLevel) {
  // 60 values within half a grey level, and 20 in each of ten others.
  Image<double> map({260, 1});
  for (int i = 0; i < 260; ++i) map(i, 0) = i < 60 ? i / 120.0 : 10 + (i - 60) / 20.0;
  EXPECT_NEAR(ambient_estimate(map).mode, 59 / 240.0, 1e-9);

  Image<double> two({100, 1});
  for (int i = 0; i < 100; i += 2) two(i, 0) = 2;
  EXPECT_NEAR(ambient_estimate(two).variance, 100 / 99.0, 1e-9);
}

}  // namespace slipstream::photometry_test
