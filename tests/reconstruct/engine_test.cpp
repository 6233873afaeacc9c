// One engine, several outputs, threads and kinds of memory.
#include "slipstream/engine.h"

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <functional>
#include <string>
#include <thread>
#include <type_traits>
#include <utility>
#include <vector>

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include "bench/vector_target.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/strategy.h"
#include "slipstream/virtual_scanner.h"
#include "tests/own_strategies.h"
#include "tests/simulate/traced_scene.h"

namespace slipstream::engine_test {

constexpr double ambient = 5;

std::vector<Strategy> all_strategies() {
  std::vector<Strategy> all = own_strategies();
  all.push_back(PhaseMeasuring{.steps = 4, .frequency = 1});
  all.push_back(PhaseMeasuring{.steps = 5, .frequency = 0.8});
  all.push_back(DualFrequency{.steps = 4, .low_steps = 3});
  for (const int steps : {3, 4, 5}) all.push_back(make_strategy("pcmp", {{"steps", steps}}));
  return all;
}

Scanner scanner_of(Size size) {
  Scanner scanner = example_scanner(size);
  scanner.photometry.ambient = ambient;
  return scanner;
}

FrameSet frames_of(const Scanner& scanner, const Strategy& strategy, int bits = 8) {
  return scan_of_scene("statue", scanner, pattern_set(strategy, Axis::x),
                       {.ambient = ambient, .noise_variance = 4, .bits = bits})
      .frames;
}

std::vector<ReconstructSettings> both_engines() {
  return {{.engine = EngineKind::fused, .clean = CleanSettings::none()},
          {.engine = EngineKind::reference, .clean = CleanSettings::none()}};
}

template <class Pixel>
bool same_bytes(const Image<Pixel>& a, const Image<Pixel>& b) {
  return a.size() == b.size() &&
         (a.empty() || std::memcmp(a.begin(), b.begin(), a.pixel_count() * sizeof(Pixel)) == 0);
}

bool same_points(const Cloud& a, const Cloud& b) {
  return same_bytes(a.x, b.x) && same_bytes(a.y, b.y) && same_bytes(a.z, b.z) &&
         same_bytes(a.validity, b.validity);
}

bool same_bytes(const Cloud& a, const Cloud& b) {
  return same_points(a, b) && same_bytes(a.intensity, b.intensity);
}

bool same_bytes(const Maps& a, const Maps& b) {
  return same_bytes(a.mean, b.mean) && same_bytes(a.modulation, b.modulation) &&
         same_bytes(a.wrapped_phase, b.wrapped_phase) &&
         same_bytes(a.fringe_order_doubt, b.fringe_order_doubt) &&
         same_bytes(a.coordinate, b.coordinate);
}

TEST(Engine, LeastModulationIsInGreyLevelsOf255WhateverTheBits) {
  const Scanner scanner = example_scanner({64, 48});
  const auto points = [&](int bits, EngineKind kind) {
    const FrameSet frames = scan_of_scene("board", scanner, pattern_set(DualFrequency{}, Axis::x),
                                          {.ambient = 5, .noise_variance = 0, .bits = bits})
                                .frames;
    Engine engine(scanner, {.strategy = DualFrequency{}},
                  {.engine = kind, .minimum_modulation = 60});
    Cloud cloud;
    engine.cloud(frames, cloud);
    return static_cast<double>(point_count(cloud));
  };
  for (const EngineKind kind : {EngineKind::fused, EngineKind::reference}) {
    const double of_8_bits = points(8, kind);
    EXPECT_GT(of_8_bits, 100);
    EXPECT_LT(of_8_bits, 0.95 * 64 * 48);
    EXPECT_NEAR(points(12, kind), of_8_bits, 0.01 * of_8_bits);
  }
}

void expect_points_of(const Cloud& cloud, const PackedPoints& points) {
  std::size_t count = 0;
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    if (cloud.validity.begin()[i] != Validity::valid) continue;
    const std::size_t n = count++;
    ASSERT_LT(n, points.count);
    ASSERT_EQ(points.x.begin()[n], cloud.x.begin()[i]);
    ASSERT_EQ(points.y.begin()[n], cloud.y.begin()[i]);
    ASSERT_EQ(points.z.begin()[n], cloud.z.begin()[i]);
    ASSERT_EQ(points.intensity.begin()[n], cloud.intensity.begin()[i]);
  }
  EXPECT_EQ(points.count, count);
}

TEST(Engine, PointsAreThoseOfTheCloud) {
  for (const Strategy& strategy : all_strategies()) {
    const Scanner scanner = scanner_of({99, 200});
    const FrameSet frames = frames_of(scanner, strategy);
    for (const ReconstructSettings& settings : both_engines()) {
      Engine engine(scanner, {.strategy = strategy}, settings);
      SCOPED_TRACE(strategy.name() + ", " + engine.backend_for(frames));
      Cloud cloud;
      PackedPoints points;
      for (const int threads : {1, 2}) {
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                        static_cast<std::size_t>(threads));
        for (const std::string& target : vector_targets()) {
          const OnlyVectorTarget only(target);
          engine.cloud(frames, cloud);
          engine.points(frames, points);
          expect_points_of(cloud, points);
        }
      }
    }
  }
}

TEST(Engine, CloudAndMapsAreThoseOfEachAlone) {
  const Scanner scanner = scanner_of({99, 64});
  for (const Strategy& strategy : all_strategies()) {
    for (const ReconstructSettings& settings : both_engines()) {
      for (const int bits : {8, 12}) {
        const FrameSet frames = frames_of(scanner, strategy, bits);
        Engine engine(scanner, {.strategy = strategy}, settings);
        SCOPED_TRACE(testing::Message()
                     << strategy.name() << " of " << frames.count() << " frames of " << bits
                     << " bits, " << engine.backend_for(frames));
        Cloud cloud, cloud_alone;
        Maps maps, maps_alone;
        Depth depth;
        engine.cloud_and_maps(frames, cloud, maps);
        engine.cloud(frames, cloud_alone);
        engine.maps(frames, maps_alone);
        engine.depth(frames, depth);
        const DepthScale scale{.scale = 0.02F, .offset = 100};
        Image<std::uint16_t> numbers;
        engine.depth(frames, scale, numbers);
        EXPECT_GT(point_count(cloud), 2000U);
        EXPECT_TRUE(same_points(cloud, cloud_alone));
        PackedPoints points;
        engine.points(frames, points);
        expect_points_of(cloud_alone, points);
        EXPECT_TRUE(same_bytes(maps, maps_alone));
        EXPECT_TRUE(same_bytes(depth.validity, cloud.validity));
        for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
          ASSERT_NEAR(cloud.intensity.begin()[i], cloud_alone.intensity.begin()[i], 1e-4);
          ASSERT_EQ(numbers.begin()[i] != 0, cloud.validity.begin()[i] == Validity::valid);
          if (cloud.validity.begin()[i] != Validity::valid) continue;
          ASSERT_NEAR(numbers.begin()[i], scale(cloud.z.begin()[i]), 1);
          ASSERT_EQ(depth.z.begin()[i], cloud.z.begin()[i]);
        }
      }
    }
  }
}

TEST(Engine, OutputsOfAnotherScanAreWrittenAnew) {
  const Scanner scanner = scanner_of({160, 90}), other = scanner_of({64, 48});
  for (const ReconstructSettings& settings : both_engines()) {
    Cloud cloud;
    Maps maps;
    // Of another size, and with a doubt that one band does not have.
    const Strategy dual = DualFrequency{}, one_band = PhaseMeasuring{};
    Engine(other, {.strategy = dual}, settings).cloud_and_maps(frames_of(other, dual), cloud, maps);
    EXPECT_FALSE(maps.fringe_order_doubt.empty());
    Engine engine(scanner, {.strategy = one_band}, settings);
    const FrameSet frames = frames_of(scanner, one_band);
    engine.cloud_and_maps(frames, cloud, maps);
    EXPECT_TRUE(maps.fringe_order_doubt.empty());
    Cloud fresh_cloud;
    Maps fresh_maps;
    engine.cloud_and_maps(frames, fresh_cloud, fresh_maps);
    EXPECT_TRUE(same_bytes(cloud, fresh_cloud));
    EXPECT_TRUE(same_bytes(maps, fresh_maps));
  }
}

/// Regions of pictures that are larger, at odd places of them, with other light all around.
template <class Pixel>
std::vector<Image<Pixel>> surrounded(const Frames<Pixel>& frames, int left, int top, Pixel around) {
  std::vector<Image<Pixel>> pictures;
  for (const auto& frame : frames) {
    Image<Pixel>& picture =
        pictures.emplace_back(Size{frame.width() + left + 13, frame.height() + top + 5}, around);
    for (int row = 0; row < frame.height(); ++row) {
      std::copy_n(frame.row(row), frame.width(), picture.row(row + top) + left);
    }
  }
  return pictures;
}

template <class Pixel>
Frames<Pixel> regions(const std::vector<Image<Pixel>>& pictures, Size size, int left, int top) {
  Frames<Pixel> views;
  for (const Image<Pixel>& picture : pictures) {
    views.emplace_back(picture.row(top) + left, size, picture.width());
  }
  return views;
}

void expect_as_copies(const Scanner& scanner, const Strategy& strategy, const FrameViews& views,
                      const FrameViews& copies) {
  for (const ReconstructSettings& settings : both_engines()) {
    Engine engine(scanner, {.strategy = strategy}, settings);
    SCOPED_TRACE(strategy.name() + ", " + engine.backend_for(copies));
    EXPECT_EQ(engine.backend_for(views), engine.backend_for(copies));
    Cloud cloud, expected_cloud;
    Maps maps, expected_maps;
    engine.cloud_and_maps(views, cloud, maps);
    engine.cloud_and_maps(copies, expected_cloud, expected_maps);
    EXPECT_TRUE(same_bytes(cloud, expected_cloud));
    EXPECT_TRUE(same_bytes(maps, expected_maps));
    engine.cloud(views, cloud);
    engine.cloud(copies, expected_cloud);
    EXPECT_TRUE(same_bytes(cloud, expected_cloud));
    EXPECT_GT(point_count(cloud), 2000U);
  }
}

TEST(Engine, RegionsOfLargerPicturesDecodeAsCopiesDo) {
  const Scanner scanner = scanner_of({101, 60});
  for (const Strategy& strategy : all_strategies()) {
    for (const int bits : {8, 12}) {
      SCOPED_TRACE(bits);
      const FrameSet copies = frames_of(scanner, strategy, bits);
      copies.visit([&]<class Pixel>(const Frames<Pixel>& frames) {
        constexpr int left = 7, top = 3;
        const auto around = static_cast<Pixel>(copies.full_scale());
        const auto pictures = surrounded<Pixel>(frames, left, top, around);
        Frames<Pixel> views = regions<Pixel>(pictures, frames.front().size(), left, top);
        if constexpr (std::is_same_v<Pixel, std::uint16_t>) {
          expect_as_copies(scanner, strategy, FrameViews(views, bits), copies);
        } else {
          expect_as_copies(scanner, strategy, FrameViews(views), copies);
        }
      });
    }
  }
}

TEST(Engine, CopiesWorkInThreadsOfTheirOwn) {
  const Scanner scanner = scanner_of({96, 64});
  constexpr int rounds = 6;
  for (const Strategy& strategy : all_strategies()) {
    for (const ReconstructSettings& settings : both_engines()) {
      SCOPED_TRACE(strategy.name());
      const FrameSet frames = frames_of(scanner, strategy);
      Engine engine(scanner, {.strategy = strategy}, settings);
      Cloud cloud;
      Maps maps;
      engine.cloud_and_maps(frames, cloud, maps);
      std::vector<int> same(2);
      const auto work = [&](Engine own, int& count) {
        Cloud own_cloud;
        Maps own_maps;
        for (int round = 0; round < rounds; ++round) {
          own.cloud_and_maps(frames, own_cloud, own_maps);
          count += same_bytes(own_cloud, cloud) && same_bytes(own_maps, maps) ? 1 : 0;
        }
      };
      std::thread first(work, engine, std::ref(same[0]));
      std::thread second(work, engine, std::ref(same[1]));
      first.join();
      second.join();
      EXPECT_EQ(same, (std::vector{rounds, rounds}));
    }
  }
}

TEST(Engine, IsAssignedAndMoved) {
  const Scanner scanner = scanner_of({64, 48});
  const Strategy strategy = DualFrequency{}, other = PhaseMeasuring{};
  const FrameSet frames = frames_of(scanner, strategy);
  Engine engine(scanner, {.strategy = strategy});
  Cloud expected, cloud;
  engine.cloud(frames, expected);
  Engine assigned(scanner, {.strategy = other});
  EXPECT_THROW(assigned.cloud(frames, cloud), Error);
  assigned = engine;
  EXPECT_EQ(assigned.setup().sequence.strategy, strategy);
  assigned.cloud(frames, cloud);
  EXPECT_TRUE(same_bytes(cloud, expected));
  Engine moved(std::move(engine));
  moved.cloud(frames, cloud);
  EXPECT_TRUE(same_bytes(cloud, expected));
}

}  // namespace slipstream::engine_test
