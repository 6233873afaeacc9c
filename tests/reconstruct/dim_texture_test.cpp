#include <cmath>
#include <cstdint>
#include <random>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "codes/predicted_variance.h"
#include "decode/cue_evidence.h"
#include "decode/equations.h"
#include "paper/formulas.h"
#include "reconstruct/engine_setup.h"
#include "slipstream/engine.h"
#include "slipstream/named_scenes.h"
#include "slipstream/phase_channel_multiplexing.h"
#include "slipstream/virtual_scanner.h"
#include "tests/simulate/traced_scene.h"

// Where noise hides the cue from a pixel and from its neighbours, there is no point.

namespace slipstream::dim_texture_test {

constexpr double ambient = 5, noise_variance = 1.55;

struct Coding {
  int steps;
  double high;
};

EngineSetup setup_for_dim(const Coding& coding, const PatternLight& light) {
  EngineSetup setup{.scanner = example_scanner({320, 240})};
  setup.scanner.photometry.ambient = ambient;
  setup.scanner.photometry.noise_variance = noise_variance;
  setup.sequence.strategy = PhaseChannelMultiplexing{
      .steps = coding.steps, .high = coding.high, .share = {}, .reference = {}};
  setup.sequence.light = light;
  setup.settings.clean = CleanSettings::none();
  return setup;
}

/// A board of which each patch of `patch` x `patch` pixels has a reflectivity of its own.
FrameSet frames_of(const PatternSet& patterns, const Image<double>& y, int patch, double most) {
  std::mt19937 random(9);
  std::uniform_real_distribution<double> any(0.12, most);
  std::normal_distribution<double> noise(0, std::sqrt(noise_variance));
  Image<double> reflectivity(y.size());
  for (int row = 0; row < y.height(); ++row) {
    for (int column = 0; column < y.width(); ++column) {
      reflectivity(column, row) = row % patch == 0 && column % patch == 0
                                      ? any(random)
                                      : reflectivity(column / patch * patch, row / patch * patch);
    }
  }
  FrameSet::Images8 frames;
  for (int n = 0; n < patterns.count; ++n) {
    auto& frame = frames.emplace_back(y.size());
    for (std::size_t i = 0; i < y.pixel_count(); ++i) {
      const double lit = std::isnan(y.begin()[i]) ? 0 : patterns.intensity(n, y.begin()[i]);
      const double I = reflectivity.begin()[i] * (lit + ambient) + ambient + noise(random);
      frame.begin()[i] = static_cast<std::uint8_t>(std::lround(std::max(I, 0.0)));
    }
  }
  return FrameSet(std::move(frames));
}

struct Shown {
  int points = 0, wrong = 0;
};

Shown shown_of(const EngineSetup& setup, int patch, double most) {
  const PatternSet patterns =
      pattern_set(setup.sequence.strategy, setup.sequence.axis, setup.sequence.light);
  const Image<double> y = scan_of_scene("board", setup.scanner, patterns).coordinate;
  Cloud cloud;
  Maps maps;
  Engine(setup).cloud_and_maps(frames_of(patterns, y, patch, most), cloud, maps);
  const double half_period = 0.5 / highest_frequency(setup.sequence.strategy.layout());
  Shown shown;
  for (std::size_t i = 0; i < y.pixel_count(); ++i) {
    if (cloud.validity.begin()[i] != Validity::valid) continue;
    ++shown.points;
    if (!(std::abs(maps.coordinate.begin()[i] - y.begin()[i]) < half_period)) ++shown.wrong;
  }
  return shown;
}

TEST(DimTexture, ShowsNoWrongPoints) {
  for (const EngineKind engine : {EngineKind::automatic, EngineKind::reference}) {
    for (const PatternLight light : {PatternLight{.alpha_p = 200, .beta_p = 55}, PatternLight{}}) {
      for (const int patch : {1, 8, 60}) {
        for (const double most : {0.3, 0.6}) {
          EngineSetup setup = setup_for_dim({3, 6}, light);
          setup.settings.engine = engine;
          const Shown shown = shown_of(setup, patch, most);
          SCOPED_TRACE(fmt::format("patches of {} px up to {}", patch, most));
          EXPECT_LE(shown.wrong, 0.01 * shown.points);
          if (most > 0.5) EXPECT_GT(shown.points, 10000);
        }
      }
    }
  }
}

TEST(DimTexture, IsAskedForNoMoreLightByTheDefaults) {
  for (const Coding& coding : {Coding{3, 3}, Coding{4, 6}, Coding{5, 12}}) {
    const EngineSetup setup = setup_for_dim(coding, {.alpha_p = 200, .beta_p = 55});
    EXPECT_EQ(least_modulation(setup), setup.settings.minimum_modulation) << coding.steps;
  }
}

TEST(DimTexture, LeastModulationIsWhereTheCuesPrintedVarianceHidesThePeriod) {
  const PatternLight light{.alpha_p = 200, .beta_p = 55};
  const auto reflectivity_at_least = [&](const Coding& coding) {
    const EngineSetup setup = setup_for_dim(coding, light);
    const Layout& layout = setup.sequence.strategy.layout();
    return 2 * CueEvidence(layout, cue_settings(setup)).least_modulation() /
           (layout.bands[0].share * light.alpha_p);
  };
  constexpr double limit = 0.6, pi = 3.14159265358979;  // periods
  // (3.67) at y = 0.85, where R = 0.7, and R changes by 2 / f_h over a period.
  const double of_three =
      dc_reference_variance(reflectivity_at_least({3, 6}), light, ambient, 0.5, 0.7);
  EXPECT_NEAR(std::sqrt(noise_variance * of_three) / (2.0 / 6), limit, 1e-9);
  // (3.76) likewise, where R is a cosine.
  const double period = std::cos(pi * (0.15 - 0.5 / 12)) - std::cos(pi * (0.15 + 0.5 / 12));
  const double of_four = half_phase_reference_variance(reflectivity_at_least({4, 12}),
                                                       light.alpha_p, 0.6, std::cos(pi * 0.15));
  EXPECT_NEAR(std::sqrt(noise_variance * of_four) / period, limit, 1e-9);
  // (3.101), where a period is that share of the turn.
  const double of_five =
      phase_variance(5, 0.4 * reflectivity_at_least({5, 25}), light.alpha_p, noise_variance);
  EXPECT_NEAR(std::sqrt(of_five) / (2 * pi / 25), limit, 1e-9);
}

}  // namespace slipstream::dim_texture_test
