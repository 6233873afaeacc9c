#include "response/automatic_exposure.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "decode/phase_decoder.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_shifting.h"
#include "slipstream/virtual_scanner.h"
#include "tests/io/expect_error.h"

namespace slipstream::automatic_exposure_test {

const Scanner scanner = example_scanner({96, 72});

/// Modulation of each pixel with one exposure; 0 where it is saturated.
std::vector<double> modulation_of(const FrameSet& frames, const Strategy& strategy) {
  const Band& band = strategy.layout().bands.front();
  const Image<double> B = PhaseDecoder(PhaseMethod::equation, {})(frames.views(), band).modulation;
  const Image<std::uint8_t> saturated = saturation_mask(frames);

  std::vector<double> modulation;
  for (std::size_t i = 0; i < B.pixel_count(); ++i) {
    modulation.push_back(saturated.begin()[i] != 0 ? 0 : B.begin()[i]);
  }
  return modulation;
}

/// A virtual camera that takes scans with any exposure.
class VirtualShots {
 public:
  explicit VirtualShots(const std::string& scene, double brightness = 1)
      : brightness_(brightness),
        first_(take_scan(scanner, scene_named(scene, scanner), patterns(1), light())) {}

  [[nodiscard]] FrameSet take(double exposure) const {
    return take_again(first_, patterns(exposure * brightness_), light());
  }

  /// See modulation_of.
  [[nodiscard]] const std::vector<double>& modulation(double exposure) const {
    std::vector<double>& of = known_[exposure];
    if (of.empty()) of = modulation_of(take(exposure), sequence().strategy);
    return of;
  }

  [[nodiscard]] static Sequence sequence() {
    return {.strategy = PhaseMeasuring{.steps = 4}, .projector = scanner.projector.size};
  }

 private:
  static Photometry light() { return {.ambient = 10, .noise_variance = 1.6, .bits = 8}; }

  static PatternSet patterns(double exposure) {
    Sequence with = sequence();
    with.exposures = {exposure};
    return pattern_set(with);
  }

  double brightness_;
  VirtualScan first_;
  mutable std::map<double, std::vector<double>> known_;
};

/// Share of the pixels that these exposures measure, from the frames themselves: merging adds
/// modulations with the exposures as weights.
double measured(const VirtualShots& shots, const std::vector<double>& exposures) {
  constexpr double least = 15;

  std::vector<const std::vector<double>*> of_each;
  for (const double exposure : exposures) of_each.push_back(&shots.modulation(exposure));

  std::size_t count = 0;
  for (std::size_t i = 0; i < of_each.front()->size(); ++i) {
    double sum = 0, squares = 0;
    for (std::size_t e = 0; e < exposures.size(); ++e) {
      if ((*of_each[e])[i] == 0) continue;
      sum += exposures[e] * (*of_each[e])[i];
      squares += exposures[e] * exposures[e];
    }
    count += squares > 0 && sum / std::sqrt(squares) >= least ? 1 : 0;
  }
  return static_cast<double>(count) / static_cast<double>(of_each.front()->size());
}

/// The best of all sets of up to `most` exposures, half a stop apart.
double best_measured(const VirtualShots& shots, std::size_t most) {
  std::vector<double> grid;
  for (double exposure = 1.0 / 32; exposure < 33; exposure *= std::sqrt(2.0)) {
    grid.push_back(exposure);
  }

  double best = 0;
  for (const double a : grid) {
    best = std::max(best, measured(shots, {a}));
    for (const double b : grid) {
      if (most < 2 || b <= a) continue;
      best = std::max(best, measured(shots, {a, b}));
      for (const double c : grid) {
        if (most < 3 || c <= b) continue;
        best = std::max(best, measured(shots, {a, b, c}));
      }
    }
  }
  return best;
}

ChosenExposures choose(const VirtualShots& shots, const ExposureLimits& limits) {
  return choose_exposures([&](double exposure) { return shots.take(exposure); },
                          VirtualShots::sequence(), limits, {}, [] { return true; });
}

void expect_nearly_best(const std::string& scene, double brightness) {
  const VirtualShots shots(scene, brightness);
  for (const std::size_t most : {1U, 2U, 3U}) {
    const ChosenExposures chosen =
        choose(shots, {.shortest = 1.0 / 32, .longest = 32, .most = most});
    EXPECT_LE(chosen.exposures.size(), most);
    const double ours = measured(shots, chosen.exposures), best = best_measured(shots, most);
    EXPECT_GE(ours, best - 0.01) << scene << ", " << most << " exposures, "
                                 << testing::PrintToString(chosen.exposures);
  }
}

TEST(AutomaticExposure, MeasuresNearlyAsManyPixelsAsTheBest) {
  expect_nearly_best("contrast", 1);
  expect_nearly_best("statue", 1);
  expect_nearly_best("sphere", 6);
}

TEST(AutomaticExposure, MeasuresNearlyAsManyPixelsAsTheBestInAllScenes) {
  for (const std::string_view scene : scene_names()) {
    for (const double brightness : {0.2, 5.0}) expect_nearly_best(std::string(scene), brightness);
  }
}

TEST(AutomaticExposure, StaysWithinItsLimitsAndItsTime) {
  const VirtualShots shots("contrast");
  const ChosenExposures chosen =
      choose(shots, {.first = 2, .shortest = 1, .longest = 3, .total = 3});
  double total = 0;
  for (const double exposure : chosen.exposures) {
    EXPECT_GE(exposure, 1);
    EXPECT_LE(exposure, 3);
    total += exposure;
  }
  EXPECT_LE(total, 3.05);

  // Without time only the first scan is taken.
  const ChosenExposures hurried =
      choose_exposures([&](double exposure) { return shots.take(exposure); },
                       VirtualShots::sequence(), {}, {}, [] { return false; });
  EXPECT_EQ(hurried.tried, std::vector<double>{1});
  EXPECT_FALSE(hurried.exposures.empty());
}

TEST(AutomaticExposure, IsWholePeriodsOfTheRoomsLight) {
  const VirtualShots shots("statue", 0.05);  // exposures of about 10
  const ChosenExposures chosen = choose(shots, {.longest = 200, .flicker_period = 4});
  for (const double exposure : chosen.exposures) {
    if (exposure < 2) continue;
    EXPECT_NEAR(std::remainder(exposure, 4), 0, 1e-9) << exposure;
  }
}

// As at 60 Hz under mains of 50 Hz, whose common period is three refreshes.
TEST(AutomaticExposure, IsWholeRefreshesWhereItIsTooShortForThePeriodsOfTheLight) {
  const VirtualShots shots("statue", 0.05);  // exposures of about 10
  const auto chosen = [&](double flicker, double refresh) {
    return choose(shots, {.longest = 200, .flicker_period = flicker, .refresh_period = refresh})
        .exposures;
  };

  const std::vector<double> unrounded = chosen(0, 0), whole = chosen(1000, 4);
  EXPECT_TRUE(std::ranges::any_of(unrounded, [](double exposure) { return exposure >= 2; }));
  for (const double exposure : whole) {
    if (exposure < 2) continue;
    EXPECT_NEAR(std::remainder(exposure, 4), 0, 1e-9) << exposure;
  }

  // Longer ones are whole periods of both.
  for (const double exposure : chosen(20, 4)) {
    if (exposure < 2) continue;
    EXPECT_NEAR(std::remainder(exposure, exposure < 10 ? 4 : 20), 0, 1e-9) << exposure;
  }
}

TEST(AutomaticExposure, SaysThatNoPatternsAreSeen) {
  const FrameSet dark(std::vector<Image<std::uint8_t>>(4, Image<std::uint8_t>({20, 20}, 9)));
  expect_error(
      [&] {
        (void)choose_exposures([&](double) { return dark; }, VirtualShots::sequence(),
                               {.longest = 100}, {}, [] { return true; });
      },
      {"no exposure", "100"});
}

/// Levels of frames under light that flickers with that frequency, at irregular times.
std::pair<std::vector<double>, std::vector<double>> room(double frequency, double amplitude,
                                                         double rate, int frames = 48) {
  std::mt19937 random(7);
  std::normal_distribution<double> noise(0, 0.02), jitter(0, 0.0002);
  std::vector<double> times, levels;
  for (int n = 0; n < frames; ++n) {
    times.push_back(n / rate + jitter(random));
    const double wave = std::sin(2 * std::numbers::pi * frequency * times.back() + 1);
    levels.push_back(80 * (1 + amplitude * wave) + 0.01 * n + noise(random));
  }
  return {times, levels};
}

TEST(AutomaticExposureFlickerPeriod, IsThatOfTheMains) {
  for (const double rate : {23.0, 31.0, 53.0, 97.0}) {
    const auto [times_50, levels_50] = room(100, 0.03, rate);
    EXPECT_EQ(flicker_period(times_50, levels_50), 0.01) << rate;
    const auto [times_60, levels_60] = room(120, 0.03, rate);
    EXPECT_NEAR(flicker_period(times_60, levels_60).value_or(0), 1.0 / 120, 1e-12) << rate;
  }
}

TEST(AutomaticExposureFlickerPeriod, OfSteadyLightOrFewFramesIsNone) {
  const auto [times, levels] = room(100, 0.001, 31);
  EXPECT_FALSE(flicker_period(times, levels));
  const auto [few_times, few_levels] = room(100, 0.03, 31, 12);
  EXPECT_FALSE(flicker_period(few_times, few_levels));
  const auto [other_times, other_levels] = room(83, 0.03, 31);
  EXPECT_FALSE(flicker_period(other_times, other_levels));
}

// At 10 frames per second both frequencies look alike.
TEST(AutomaticExposureFlickerPeriod, OfEitherMainsIsWholePeriodsOfBoth) {
  std::vector<double> times, levels;
  for (int n = 0; n < 40; ++n) {
    times.push_back(n / 110.0);
    levels.push_back(80 + 3 * std::cos(2 * std::numbers::pi * 100 * times.back()));
  }
  EXPECT_NEAR(flicker_period(times, levels).value_or(0), 0.05, 1e-12);
}

}  // namespace slipstream::automatic_exposure_test
