// Projectors of any response: what calibration makes of their depth, and that nothing makes it
// worse than it was.
#include <cmath>
#include <functional>
#include <numbers>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "decode/phase_decoder.h"
#include "paper/formulas.h"
#include "response/correction.h"
#include "response/gamma_calibration.h"
#include "response/response_fit.h"
#include "response/scan_average.h"
#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/gamma.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"

namespace slipstream::any_response_test {

struct Projector {
  std::string name;
  Response response;
};

void PrintTo(const Projector& projector, std::ostream* stream) {
  *stream << projector.name;
}

/// As a table of 33 levels gives it.
Projector table(const std::string& name, const std::function<double(double)>& light) {
  std::vector<double> values, intensities;
  for (int i = 0; i <= 32; ++i) {
    values.push_back(i / 32.0);
    intensities.push_back(light(values.back()));
  }
  return {name, response_curve(values, intensities)};
}

std::vector<Projector> power_laws(const std::vector<double>& gammas) {
  std::vector<Projector> projectors;
  for (const double gamma : gammas) {
    projectors.push_back({fmt::format("power {}", gamma), PowerLaw{gamma}});
  }
  return projectors;
}

std::vector<Projector> logistics(const std::vector<double>& slopes,
                                 const std::vector<double>& centres) {
  std::vector<Projector> projectors;
  for (const double slope : slopes) {
    for (const double centre : centres) {
      projectors.push_back(
          {fmt::format("logistic {} {}", slope, centre), logistic_curve(slope, centre)});
    }
  }
  return projectors;
}

/// Such as are measured on projectors of micromirrors.
std::vector<Projector> tables() {
  return {
      table("S-shape with a toe", [](double v) { return 0.3 * v * v + 0.7 * v * v * (3 - 2 * v); }),
      table("2.2, clipped", [](double v) { return std::pow(std::min(v / 0.9, 1.0), 2.2); }),
      table("2.2, wavy",
            [](double v) { return std::pow(v, 2.2) * (1 + 0.15 * std::sin(6.283185 * v)); }),
      table("boosted white", [](double v) { return v < 0.8 ? 0.7 * v : 0.56 + 2.2 * (v - 0.8); })};
}

/// Before a white board, traced once, with noise of 1.55 grey levels^2 and 8 bits.
class Bench {
 public:
  static const Bench& bench() {
    static const Bench once;
    return once;
  }

  [[nodiscard]] FrameSet frames(const Sequence& sequence, const Response& response,
                                std::uint64_t seed = 1, double ambient = 5) const {
    return take_again(world_, pattern_set(sequence), light(response, seed, ambient));
  }
  [[nodiscard]] GammaCalibration calibrated(const Response& response, int steps) const {
    const Sequence sequence = sequence_of(PhaseMeasuring{.steps = steps, .frequency = 8});
    ScanAverage scans;
    scans.add({.frames = frames(sequence, response, 7), .sequence = sequence}, "a scan");
    return calibrate_gamma(scans);
  }
  /// 33 levels, each the mean of the picture's middle.
  [[nodiscard]] NamedResponse from_uniform(const Response& response) const {
    constexpr int last = 32;
    const PatternSet levels{
        .count = last + 1, .axis = Axis::x, .light = {}, .shape = [](int n, double) {
          return static_cast<double>(n) / last;
        }};
    const FrameSet seen = take_again(world_, levels, light(response, 9, 5));
    std::vector<double> values, intensities;
    seen.views().visit([&](const auto& views) {
      for (int n = 0; n <= last; ++n) {
        double sum = 0, count = 0;
        for (int row = 45; row < 75; ++row) {
          for (int column = 60; column < 100; ++column, ++count) {
            sum += static_cast<double>(views[static_cast<std::size_t>(n)](column, row));
          }
        }
        values.push_back(static_cast<double>(n) / last);
        intensities.push_back(sum / count);
      }
    });
    return simplest_response(values, intensities);
  }
  /// RMS of the depth, mm, that a scan shows where `corrected` is known of the projector.
  [[nodiscard]] double rms(const Sequence& sequence, const FrameSet& frames,
                           const std::optional<MeasuredResponse>& corrected) const {
    Scanner scanner = scanner_;
    scanner.photometry.response = corrected;
    Cloud cloud;
    Engine(scanner, sequence, {.clean = CleanSettings::none()}).cloud(frames, cloud);
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
      const double error = static_cast<double>(cloud.z.begin()[i]) - world_.depth.begin()[i];
      if (!std::isfinite(error)) continue;
      sum += error * error;
      ++count;
    }
    EXPECT_GT(count, 15000);
    return std::sqrt(sum / count);
  }
  /// RMS of the depth's errors over the sigma that the engine says of each.
  [[nodiscard]] double normalised_rms(const Sequence& sequence, const FrameSet& frames,
                                      const MeasuredResponse& corrected) const {
    Scanner scanner = scanner_;
    scanner.photometry = {.noise_variance = 1.55 + 1.0 / 12, .response = corrected};
    Engine engine(scanner, sequence, {.clean = CleanSettings::none()});
    Cloud cloud;
    Maps maps;
    engine.cloud_and_maps(frames, cloud, maps);
    const Uncertainty sigma = engine.uncertainty(cloud, maps, frames);
    double sum = 0, count = 0;
    for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
      const double error = static_cast<double>(cloud.z.begin()[i]) - world_.depth.begin()[i];
      if (!std::isfinite(error)) continue;
      sum += std::pow(error / static_cast<double>(sigma.z_of_noise.begin()[i]), 2);
      ++count;
    }
    return std::sqrt(sum / count);
  }
  [[nodiscard]] Sequence sequence_of(const Strategy& strategy) const {
    return {strategy, Axis::x, {}, scanner_.projector.size};
  }

 private:
  static Photometry light(const Response& response, std::uint64_t seed, double ambient) {
    return {.ambient = ambient, .response = response, .noise_variance = 1.55, .seed = seed};
  }

  Scanner scanner_ = example_scanner({160, 120});
  VirtualScan world_ = take_scan(scanner_, scene_named("board", scanner_),
                                 pattern_set(PhaseMeasuring{.steps = 3}, Axis::x));
};

class AnyResponse : public testing::TestWithParam<Projector> {
 protected:
  /// A scan of so many steps, left alone, corrected blind and for `calibrated`, beside that of a
  /// linear projector.
  void compare(int steps, const MeasuredResponse& calibrated) const {
    const Bench& bench = Bench::bench();
    const Sequence sequence =
        bench.sequence_of(DualFrequency{.steps = steps, .low_steps = 6, .high = 8, .low = 1});
    const FrameSet frames = bench.frames(sequence, GetParam().response);
    const GammaChoice blind = choose_gamma("blind", {}, sequence.strategy.layout(), frames);
    const double alone = bench.rms(sequence, frames, {});
    const double found = bench.rms(sequence, frames, blind.response);
    const double after = bench.rms(sequence, frames, calibrated);
    const double linear = bench.rms(sequence, bench.frames(sequence, PowerLaw{1}), {});
    fmt::print(
        "{:18} {} steps: left alone {:6.3f}, blind {:6.3f}, calibrated {:5.3f} mm, "
        "{:4.2f} of a linear projector's {:5.3f}\n",
        GetParam().name, steps, alone, found, after, after / linear, linear);
    EXPECT_LE(found, 1.01 * alone) << "blind, " << steps << " steps";
    EXPECT_LE(after, 1.01 * alone) << steps << " steps";
    // Fewer are less sure of some phases than of others under a bent response.
    if (steps == 6) EXPECT_LE(after, 1.2 * linear);
  }
};

TEST_P(AnyResponse, IsCalibratedOrRefusedAndNeverMadeWorse) {
  const GammaCalibration found = Bench::bench().calibrated(GetParam().response, 8);
  MeasuredResponse calibrated;
  if (found.response) {
    calibrated = found_response(found);
    fmt::print("{:18} by 8 steps: {}\n", GetParam().name, found.response->name);
  } else {
    EXPECT_THROW((void)found_response(found), Error);
    const auto [name, response] = Bench::bench().from_uniform(GetParam().response);
    calibrated.response = response;
    fmt::print("{:18} by 8 steps: refused, {:.2g} rad left; by levels: {}\n", GetParam().name,
               found.misfit, name);
  }
  compare(3, calibrated);
  compare(6, calibrated);
}

INSTANTIATE_TEST_SUITE_P(PowerLaws, AnyResponse, testing::ValuesIn(power_laws({0.5, 1, 3})));
INSTANTIATE_TEST_SUITE_P(Srgb, AnyResponse, testing::Values(Projector{"sRGB", srgb_curve()}));
INSTANTIATE_TEST_SUITE_P(SCurves, AnyResponse, testing::ValuesIn(logistics({3, 12}, {0.35, 0.5})));
INSTANTIATE_TEST_SUITE_P(Tables, AnyResponse, testing::ValuesIn(tables()));
// All that docs/background/gamma.md tells of.
INSTANTIATE_TEST_SUITE_P(DISABLED_SweepOfPowerLaws, AnyResponse,
                         testing::ValuesIn(power_laws({0.7, 1.4, 1.8, 2.2, 2.6})));
INSTANTIATE_TEST_SUITE_P(DISABLED_SweepOfSCurves, AnyResponse,
                         testing::ValuesIn(logistics({3, 4.5, 6, 7.5, 9, 10.5, 12},
                                                     {0.35, 0.4, 0.45, 0.5, 0.55, 0.6, 0.65})));

// Where the response presses phases together noise weighs more, and sigma says so.
TEST(AnyResponseUncertainty, KnowsTheNoiseThatCorrectingRaises) {
  const Bench& bench = Bench::bench();
  for (const Response& response :
       {Response(PowerLaw{2.2}), Response(logistic_curve(9, 0.45)), Response(PowerLaw{0.5})}) {
    for (const int steps : {3, 4, 6}) {
      const Sequence sequence =
          bench.sequence_of(DualFrequency{.steps = steps, .low_steps = 6, .high = 8, .low = 1});
      EXPECT_NEAR(
          bench.normalised_rms(sequence, bench.frames(sequence, response), {.response = response}),
          1, 0.1)
          << steps << " steps";
    }
  }
}

double rms_after(const PhaseCorrection& correction, const Response& response) {
  constexpr int phases = 720;
  double sum = 0;
  for (int i = 0; i < phases; ++i) {
    const double phi = 2 * std::numbers::pi * i / phases;
    const double measured = distorted_phase(response, correction.steps, phi);
    const double turn = std::fmod(measured + 4 * std::numbers::pi, 2 * std::numbers::pi);
    sum +=
        std::pow(std::remainder(corrected_phase(correction, turn) - phi, 2 * std::numbers::pi), 2);
  }
  return std::sqrt(sum / phases);
}

// One run of steps by itself, that has no longer one beside it to warn of what it cannot see.
TEST(AnyResponseBlindGamma, NeverMakesThePhaseOfItsStepsWorse) {
  std::vector<Projector> projectors = logistics({3, 12}, {0.35, 0.5, 0.65});
  projectors.push_back({"sRGB", srgb_curve()});
  for (const Projector& projector : tables()) projectors.push_back(projector);
  for (const auto& [name, response] : projectors) {
    for (const int steps : {3, 4, 5}) {
      const Sequence one_run =
          Bench::bench().sequence_of(PhaseMeasuring{.steps = steps, .frequency = 8});
      // Three steps refuse under any.
      const double ambient = steps == 3 ? 0 : 5;
      const BlindGamma found =
          find_gamma(Bench::bench().frames(one_run, response, 1, ambient), 0, steps);
      if (!found.accepted()) continue;
      const double before = rms_phase_error(response, steps);
      const double after = rms_after(phase_correction(PowerLaw{found.gamma}, steps), response);
      EXPECT_LE(after, 1.01 * before + 1e-4) << name << ", " << steps << " steps: " << found.gamma;
    }
  }
}

// Five to seven steps see too little of a curve to tell it from others of another phase error.
TEST(AnyResponseGammaCalibration, RefusesCurvesByFewSteps) {
  for (const int steps : {4, 5, 6}) {
    const GammaCalibration found = Bench::bench().calibrated(logistic_curve(9, 0.45), steps);
    EXPECT_FALSE(found.response);
    EXPECT_THROW((void)found_response(found), Error);
    EXPECT_EQ(Bench::bench().calibrated(PowerLaw{2.2}, steps).response.value().name, "power law");
  }
}

// A small flat surface shows each pattern at few phases.
TEST(AnyResponseGammaCalibration, LeavesOutValuesThatNoPixelSaw) {
  constexpr int steps = 12;
  constexpr double widest = 7.5 * std::numbers::pi / 180;
  const Response truth = tables().back().response;

  FrameSet::Images16 frames(steps, Image<std::uint16_t>({80, 50}));
  for (int n = 0; n < steps; ++n) {
    Image<std::uint16_t>& frame = frames[static_cast<std::size_t>(n)];
    for (std::size_t i = 0; i < frame.pixel_count(); ++i) {
      const double phase =
          widest * static_cast<double>(i) / static_cast<double>(frame.pixel_count() - 1);
      const double value = 0.5 + 0.5 * std::cos(phase - 2 * std::numbers::pi * n / steps);
      frame.begin()[i] =
          static_cast<std::uint16_t>(std::lround(257 * (20 + 200 * light_at(truth, value))));
    }
  }

  Scan scan;
  scan.frames = FrameSet(std::move(frames), 16);
  scan.sequence.strategy = PhaseMeasuring{.steps = steps};
  ScanAverage scans;
  scans.add(scan, "a scan");

  const std::optional<NamedResponse> found = calibrate_gamma(scans).response;
  ASSERT_TRUE(found);
  EXPECT_EQ(found->name, "measured curve");
  for (double value = 0; value <= 1; value += 0.01) {
    EXPECT_NEAR(light_at(found->response, value), light_at(truth, value), 0.02) << value;
  }
}

TEST(AnyResponseUniformLevels, AreFittedByTheSimplestResponseThatLeavesNoise) {
  const auto name_of = [](const Response& response) {
    return Bench::bench().from_uniform(response).name;
  };
  EXPECT_EQ(name_of(PowerLaw{1.8}), "power law");
  EXPECT_EQ(name_of(srgb_curve()), "srgb");
  EXPECT_EQ(name_of(logistic_curve(9, 0.45)).substr(0, 9), "logistic:");
  for (const Projector& projector : tables()) {
    EXPECT_EQ(name_of(projector.response), "measured curve") << projector.name;
  }
}

}  // namespace slipstream::any_response_test
