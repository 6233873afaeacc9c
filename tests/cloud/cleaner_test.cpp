#include "slipstream/cloud/cleaner.h"

#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <random>
#include <string>

#include <gtest/gtest.h>
#include <rapidcheck.h>
#include <tbb/global_control.h>

#include "slipstream/base/error.h"
#include "slipstream/base/vector_target.h"
#include "tests/cloud/made_up_cloud.h"

namespace slipstream::cleaner_test {

constexpr double nothing = std::numeric_limits<double>::quiet_NaN();

CleanSettings only(const std::function<void(CleanSettings&)>& change) {
  CleanSettings settings = CleanSettings::none();
  change(settings);
  return settings;
}

/// A tilted plane before a wall under noise, with holes, specks and points off it.
Cloud disturbed_cloud(unsigned seed, Size size) {
  std::mt19937 random(seed);
  std::normal_distribution<double> noise(0, 0.2);
  std::uniform_real_distribution<double> share;
  return cloud_of_depths(size, [&](int column, int row) {
    const double chance = share(random);
    if (chance < 0.02) return nothing;
    const double off = chance > 0.99 ? 60 * share(random) : 0;
    const bool near = column > size.width / 3 && row > size.height / 4;
    return (near ? 800 + 0.5 * column : 900) + off + noise(random);
  });
}

std::size_t sum_of(const ValidityCounts& counts) {
  return std::accumulate(counts.begin() + 1, counts.end(), std::size_t{0});
}

TEST(Cleaner, ComponentsAreThoseOfAPlainFlood) {
  EXPECT_TRUE(rc::check("random masks", [] {
    const Size size{*rc::gen::inRange(40, 150), *rc::gen::inRange(20, 60)};
    const int smallest = *rc::gen::inRange(2, 40), step = *rc::gen::inRange(0, 150);
    const double share = 0.1 * *rc::gen::inRange(4, 10);
    std::mt19937 random(*rc::gen::arbitrary<unsigned>());
    std::uniform_real_distribution<double> chance;
    Cloud cloud = cloud_of_depths(size, [&](int column, int) {
      return chance(random) > share ? nothing : column < step ? 800 : 1000;
    });
    const Cloud raw = cloud;
    const Image<int> sizes =
        component_sizes(raw, [](float a, float b) { return std::abs(a - b) < 100; });
    const ValidityCounts counts =
        Cleaner(only([&](auto& s) { s.smallest_component = smallest; }))(cloud);
    std::size_t dropped = 0;
    for (std::size_t i = 0; i < sizes.pixel_count(); ++i) {
      const bool stays = sizes.begin()[i] >= smallest;
      RC_ASSERT((cloud.validity.begin()[i] == Validity::valid) == stays);
      if (sizes.begin()[i] > 0 && !stays) ++dropped;
    }
    RC_ASSERT(counts[static_cast<std::size_t>(Validity::small_component)] == dropped);
  }));
}

TEST(Cleaner, TakesPointsAndNeitherAddsNorMovesAny) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const Cloud raw = disturbed_cloud(seed, {static_cast<int>(101 + seed), 80});
    Cloud cloud = raw;
    const ValidityCounts counts = Cleaner()(cloud);
    EXPECT_EQ(point_count(raw) - point_count(cloud), sum_of(counts));
    EXPECT_EQ(counts[0], 0U);
    EXPECT_GT(sum_of(counts), 30U);
    for (std::size_t i = 0; i < raw.z.pixel_count(); ++i) {
      if (cloud.validity.begin()[i] == raw.validity.begin()[i]) {
        ASSERT_EQ(std::memcmp(raw.z.begin() + i, cloud.z.begin() + i, sizeof(float)), 0);
      } else {
        ASSERT_EQ(raw.validity.begin()[i], Validity::valid);
        ASSERT_TRUE(std::isnan(cloud.x.begin()[i]) && std::isnan(cloud.z.begin()[i]));
      }
    }
  }
}

TEST(Cleaner, FindsNothingInACleanCloud) {
  const auto plane = [](int column, int row) { return 800 + 0.3 * column + 0.2 * row; };
  Cloud cloud = cloud_of_depths({160, 120}, [&](int column, int row) {
    if (column % 40 == 20 && row % 30 == 15) return plane(column, row) + 15;
    if (column > 100 && column < 104) return nothing;
    return column < 60 ? 950 : plane(column, row);
  });
  EXPECT_EQ(sum_of(Cleaner()(cloud)), 16U);
  EXPECT_EQ(sum_of(Cleaner()(cloud)), 0U);
}

TEST(Cleaner, GivesTheSameOnAnyThreadsAndVectors) {
  const Cloud raw = disturbed_cloud(7, {333, 250});
  const auto cleaned = [&] {
    Cloud cloud = raw;
    Cleaner()(cloud);
    return cloud;
  };
  const Cloud expected = cleaned();
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    EXPECT_TRUE(same_points(cleaned(), expected));
  }
  for (const std::string& target : vector_targets()) {
    const OnlyVectorTarget alone(target);
    EXPECT_TRUE(same_points(cleaned(), expected)) << target;
  }
}

TEST(Cleaner, KeepsASteepSurface) {
  // 7 pixels deep for each pixel across, which is the least steep that is given up.
  Cloud cloud = cloud_of_depths({160, 60}, [](int column, int) { return 800 + 5.6 * column; });
  EXPECT_EQ(sum_of(Cleaner()(cloud)), 0U);
}

TEST(Cleaner, NoneLeavesACloudAsItIs) {
  const Cloud raw = disturbed_cloud(3, {90, 70});
  Cloud cloud = raw;
  EXPECT_EQ(sum_of(Cleaner(CleanSettings::none())(cloud)), 0U);
  EXPECT_TRUE(same_points(cloud, raw));
  Cloud empty;
  EXPECT_EQ(sum_of(Cleaner()(empty)), 0U);
}

TEST(Cleaner, KeepsTheRegionAskedFor) {
  const auto kept_by = [](const std::function<void(CleanSettings&)>& change) {
    Cloud cloud = cloud_of_depths({100, 80}, [](int, int) { return 1000; });
    Cleaner clean(only(change));
    clean(cloud);
    return cloud;
  };
  EXPECT_EQ(point_count(kept_by([](auto& s) { s.outline = {{29, 49}, {10, 20}}; })), 20U * 30);
  const Cloud triangle = kept_by([](auto& s) { s.outline = {{10, 10}, {90, 10}, {10, 70}}; });
  EXPECT_EQ(triangle.validity(12, 50), Validity::valid);
  EXPECT_EQ(triangle.validity(80, 60), Validity::outside_region);
  EXPECT_NEAR(static_cast<double>(point_count(triangle)), 80 * 60 / 2, 90);
  // 1 mm for each pixel, from the middle.
  EXPECT_EQ(point_count(kept_by([](auto& s) {
              s.box = PointBox{{-4.5, -9.5, 900}, {4.5, 9.5, 1100}};
            })),
            9U * 19);
  EXPECT_EQ(point_count(kept_by([](auto& s) { s.box = PointBox{{-9, -9, 0}, {9, 9, 900}}; })), 0U);
}

TEST(Cleaner, FillsGapsOfOneSurfaceWithIt) {
  const auto plane = [](int column, int row) {
    return 1 / (1e-3 + 2e-7 * column - 1e-7 * row);  // what a plane is in a picture
  };
  const auto is_hole = [](int column, int row) {
    return std::abs(column - 30) <= 2 && std::abs(row - 30) <= 2;
  };
  Cloud cloud = cloud_of_depths({90, 70}, [&](int column, int row) {
    if (is_hole(column, row) || (column >= 60 && column < 67)) return nothing;
    return plane(column, row);
  });
  const ValidityCounts counts = Cleaner(only([](auto& s) { s.widest_gap = 5; }))(cloud);
  EXPECT_EQ(counts[0], 25U) << "the wide gap stays";
  for (int row = 28; row <= 32; ++row) {
    for (int column = 28; column <= 32; ++column) {
      EXPECT_NEAR(cloud.z(column, row), plane(column, row), 2e-3);
      EXPECT_NEAR(cloud.x(column, row), 1e-3 * (column - 45) * plane(column, row), 2e-3);
      EXPECT_EQ(cloud.validity(column, row), Validity::valid);
    }
  }
}

TEST(Cleaner, SmoothsNoiseAndKeepsEdges) {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0, 0.5);
  const auto surface = [](int column) { return column < 50 ? 900 : 1000; };
  Cloud cloud =
      cloud_of_depths({100, 80}, [&](int column, int) { return surface(column) + noise(random); });
  const Cloud raw = cloud;
  Cleaner(only([](auto& s) { s.smoothing = 2; }))(cloud);
  const auto rms = [&](const Cloud& of, int first, int last) {
    double sum = 0;
    for (int row = 2; row < 78; ++row) {
      for (int column = first; column < last; ++column) {
        sum += std::pow(of.z(column, row) - surface(column), 2);
      }
    }
    return std::sqrt(sum / (76 * (last - first)));
  };
  EXPECT_LT(rms(cloud, 5, 45), 0.3 * rms(raw, 5, 45));
  EXPECT_LT(rms(cloud, 48, 52), 0.7 * rms(raw, 48, 52));
  // Along their rays.
  EXPECT_NEAR(cloud.x(20, 20) / cloud.z(20, 20), raw.x(20, 20) / raw.z(20, 20), 1e-6);
}

TEST(Cleaner, RefusesSettingsOutOfRange) {
  EXPECT_THROW(Cleaner({.largest_sigma = 0}), Error);
  EXPECT_THROW(Cleaner({.smallest_component = -1}), Error);
  EXPECT_THROW(Cleaner({.box = PointBox{}}), Error);
  EXPECT_THROW(Cleaner({.outline = {{1, 1}}}), Error);
  EXPECT_THROW(Cleaner({.widest_gap = -1}), Error);
  EXPECT_THROW(Cleaner({.smoothing = 11}), Error);
}

}  // namespace slipstream::cleaner_test
