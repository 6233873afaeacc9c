// Several exposures to one cloud: points that one exposure lacks, their noise, their texture.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <map>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include "slipstream/engine.h"
#include "slipstream/error.h"
#include "slipstream/frame_set.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_world.h"

namespace slipstream::exposures_test {

VirtualWorld contrast_world(Size size = {320, 240}) {
  VirtualWorld world{.scanner = example_scanner(size),
                     .photometry = {.ambient = 5, .noise_variance = 1.55}};
  world.scene = scene_named("contrast", world.scanner);
  return world;
}

Sequence sequence_of(std::vector<double> exposures, const Strategy& strategy = DualFrequency{}) {
  return {.strategy = strategy, .exposures = std::move(exposures)};
}

VirtualScan take(const VirtualWorld& world, const Sequence& sequence) {
  return take_scan(world.scanner, world.scene, pattern_set(sequence), world.photometry);
}

/// Of the pixels that the projector lights.
double share_of_points(const VirtualWorld& world, const Sequence& sequence) {
  const VirtualScan scan = take(world, sequence);
  Cloud cloud;
  Engine(as_calibrated(world), sequence).cloud(scan.frames, cloud);
  double lit = 0, points = 0;
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    if (std::isnan(scan.coordinate.begin()[i])) continue;
    ++lit;
    if (cloud.validity.begin()[i] == Validity::valid) ++points;
  }
  return points / lit;
}

TEST(Exposures, EachMoreMeasuresMoreOfASceneOfHighContrast) {
  const VirtualWorld world = contrast_world();
  const double one = share_of_points(world, sequence_of({1}));
  const double two = share_of_points(world, sequence_of({0.5, 4}));
  const double three = share_of_points(world, sequence_of({0.3, 1.5, 8}));
  EXPECT_LT(one, 0.8);
  EXPECT_GT(two, one + 0.05);
  EXPECT_GE(three, 0.97);
}

TEST(Exposures, NoiseOfPointsIsAsPredictedWhicheverExposuresTheyAreOf) {
  const VirtualWorld world = contrast_world({480, 360});
  const Sequence sequence = sequence_of({0.5, 1, 2, 8});
  const VirtualScan scan = take(world, sequence);
  Engine engine(as_calibrated(world), sequence);
  const FrameSet frames = merged_exposures(scan.frames, sequence.exposures);
  Cloud cloud;
  Maps maps;
  engine.cloud_and_maps(frames, cloud, maps);
  const Uncertainty sigma = engine.uncertainty(cloud, maps, frames);
  struct Errors {
    double squares = 0, count = 0;
  };
  std::map<float, Errors> by_gain;
  const FrameViews views = frames;
  for (int row = 0; row < cloud.size().height; ++row) {
    for (int column = 0; column < cloud.size().width; ++column) {
      if (cloud.validity(column, row) != Validity::valid) continue;

      // Beside edges sigma has more than noise.
      if (sigma.z(column, row) > 1.05F * sigma.z_of_noise(column, row)) continue;
      const double error = maps.coordinate(column, row) - scan.coordinate(column, row);
      if (!std::isfinite(error)) continue;
      Errors& errors = by_gain[views.gain()(column, row)];
      errors.squares += std::pow(error / sigma.coordinate(column, row), 2);
      ++errors.count;
    }
  }
  int groups = 0;
  for (const auto& [gain, errors] : by_gain) {
    if (errors.count < 1000) continue;
    ++groups;
    EXPECT_NEAR(std::sqrt(errors.squares / errors.count), 1, 0.1) << "gain " << gain;
  }
  EXPECT_GE(groups, 3);
}

TEST(Exposures, EqualOnesAreTheAverageScaled) {
  const VirtualWorld world = contrast_world({64, 48});
  const Sequence sequence = sequence_of({0.5, 0.5, 0.5, 0.5}, PhaseMeasuring{.steps = 4});
  const FrameSet frames = take(world, sequence).frames;
  const FrameSet merged = merged_exposures(frames, sequence.exposures);
  ASSERT_EQ(merged.count(), 4);
  const Image<std::uint8_t> saturated = saturation_mask(frames);
  const FrameViews all = frames;
  merged.visit([&](const auto& levels) {
    for (std::size_t n = 0; n < levels.size(); ++n) {
      for (int row = 0; row < 48; ++row) {
        for (int column = 0; column < 64; ++column) {
          if (saturated(column, row) != 0) continue;
          double sum = 0;
          all.visit([&](const auto& views) {
            for (std::size_t e = 0; e < 4; ++e) {
              sum += static_cast<double>(views[4 * e + n](column, row));
            }
          });
          ASSERT_NEAR(levels[n](column, row), sum / 2 * 16383 / 255, 0.51);
        }
      }
    }
  });
}

TEST(Exposures, WhatAllSaturateStaysSaturatedAndWhatOneDoesIsLeftOut) {
  Image<std::uint8_t> dark({3, 1}), bright({3, 1}), dark_2({3, 1}), bright_2({3, 1});
  dark(0, 0) = 10, bright(0, 0) = 40;    // both count
  dark(1, 0) = 100, bright(1, 0) = 255;  // the second does not
  dark(2, 0) = 255, bright(2, 0) = 255;  // none does
  dark_2(0, 0) = 20, bright_2(0, 0) = 80;
  dark_2(1, 0) = 50, bright_2(1, 0) = 200;
  dark_2(2, 0) = 50, bright_2(2, 0) = 200;
  const FrameSet merged =
      merged_exposures(FrameSet(FrameSet::Images8{dark, dark_2, bright, bright_2}), {1, 4});
  const double level = 16383.0 / 255;
  merged.visit([&](const auto& frames) {
    EXPECT_NEAR(frames[0](0, 0), level * (10 + 4 * 40) / std::sqrt(17), 0.51);
    EXPECT_NEAR(frames[1](0, 0), level * (20 + 4 * 80) / std::sqrt(17), 0.51);
    EXPECT_NEAR(frames[0](1, 0), level * 100, 0.51);
    EXPECT_NEAR(frames[1](1, 0), level * 50, 0.51);
    EXPECT_EQ(frames[0](2, 0), 65535);
    EXPECT_NEAR(frames[1](2, 0), level * 50, 0.51);
  });
  const FrameViews views = merged;
  EXPECT_NEAR(views.gain()(0, 0), std::sqrt(17), 1e-5);
  EXPECT_EQ(views.gain()(1, 0), 1);
  const Image<std::uint8_t> saturated = saturation_mask(merged);
  EXPECT_EQ(saturated(0, 0), 0);
  EXPECT_EQ(saturated(1, 0), 0);
  EXPECT_EQ(saturated(2, 0), 1);
}

TEST(Exposures, EnginesAgreeOnMergedFrames) {
  const VirtualWorld world = contrast_world({120, 90});
  for (const Strategy& strategy :
       {Strategy(DualFrequency{}), Strategy(PhaseMeasuring{.steps = 4}),
        make_strategy("pcmp", {{"steps", 4}}), make_strategy("pcmp", {{"steps", 5}})}) {
    const Sequence sequence = sequence_of({0.5, 2, 8}, strategy);
    const FrameSet frames = take(world, sequence).frames;
    Cloud fused, reference;
    Engine(as_calibrated(world), sequence).cloud(frames, fused);
    Engine(as_calibrated(world), sequence, {.engine = EngineKind::reference})
        .cloud(frames, reference);
    std::size_t points = 0, differ = 0;
    for (std::size_t i = 0; i < fused.z.pixel_count(); ++i) {
      EXPECT_NEAR(fused.intensity.begin()[i], reference.intensity.begin()[i], 0.05);
      if (fused.validity.begin()[i] != reference.validity.begin()[i]) {
        ++differ;
      } else if (fused.validity.begin()[i] == Validity::valid) {
        ++points;
        EXPECT_NEAR(fused.z.begin()[i], reference.z.begin()[i], 0.05);
      }
    }
    EXPECT_GT(points, fused.z.pixel_count() / 2) << strategy.name();
    EXPECT_LE(differ, fused.z.pixel_count() / 1000) << strategy.name();
  }
}

TEST(Exposures, TextureHasNoSeams) {
  VirtualWorld world = contrast_world({320, 240});
  world.photometry.noise_variance = 0.1;
  const Sequence several = sequence_of({0.5, 2, 8}), shortest = sequence_of({0.5});
  Cloud merged, single;
  Engine(as_calibrated(world), several).cloud(take(world, several).frames, merged);
  Engine(as_calibrated(world), shortest).cloud(take(world, shortest).frames, single);
  for (std::size_t i = 0; i < merged.z.pixel_count(); ++i) {
    if (merged.validity.begin()[i] != Validity::valid) continue;
    ASSERT_NEAR(merged.intensity.begin()[i], single.intensity.begin()[i], 1);
  }
}

TEST(Exposures, ACueReadFromTheAmbientLightTakesOne) {
  Sequence sequence = sequence_of({1, 4}, make_strategy("pcmp", {{"steps", 3}}));
  EXPECT_THROW(require_mergeable(sequence), Error);
  sequence.exposures = {4};
  EXPECT_NO_THROW(require_mergeable(sequence));
  for (const std::vector<double>& wrong :
       {std::vector<double>{}, {0.0}, {-1.0, 1.0}, std::vector<double>(17, 1.0)}) {
    EXPECT_THROW(require_mergeable(sequence_of(wrong)), Error);
  }
}

}  // namespace slipstream::exposures_test
