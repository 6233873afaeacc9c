#include "calibrate/depth_drift.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "tests/io/expect_error.h"

namespace slipstream::depth_drift_test {

constexpr double noise = 0.002;  // mm

/// An hour of scans, two a minute, whose depth follows `drift` of the minutes.
Steadiness judged(unsigned seed, const std::function<double(double)>& drift) {
  std::mt19937 random(seed);
  std::normal_distribution<double> error(0, noise);
  std::vector<double> minutes, values;
  for (int i = 0; i < 120; ++i) {
    minutes.push_back(0.5 * i);
    values.push_back(drift(minutes.back()) + error(random));
  }
  return steadiness(minutes, values);
}

// 5 % of an exponential are left after three time constants.
TEST(DepthDrift, IsSteadyAfterThreeTimeConstantsOfAWarmUp) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    const Steadiness found =
        judged(seed, [](double minutes) { return 0.3 * (1 - std::exp(-minutes / 10)); });
    ASSERT_TRUE(found.since) << seed;
    EXPECT_NEAR(*found.since, 30, 4) << seed;
    EXPECT_NEAR(found.level, 0.3, 2 * noise) << seed;
    EXPECT_NEAR(found.noise, noise, noise / 2) << seed;
  }
}

TEST(DepthDrift, IsNotSteadyWhileDepthStillDrifts) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    const auto slow = [](double minutes) { return 0.3 * (1 - std::exp(-minutes / 40)); };
    EXPECT_FALSE(judged(seed, slow).since) << seed;
    EXPECT_FALSE(judged(seed, [](double minutes) { return 0.001 * minutes; }).since) << seed;
    EXPECT_FALSE(judged(seed, [](double minutes) { return minutes < 50 ? 0 : 0.1; }).since) << seed;
  }
}

TEST(DepthDrift, IsSteadyFromTheStartWithoutDrift) {
  for (unsigned seed = 0; seed < 100; ++seed) {
    EXPECT_EQ(judged(seed, [](double) { return 0.0; }).since, 0.0) << seed;
    // One bad scan.
    EXPECT_EQ(judged(seed, [](double minutes) { return minutes == 45 ? 1 : 0; }).since, 0.0)
        << seed;
  }

  const std::vector<double> times{0, 1, 2, 3, 4, 5, 6, 7, 8}, equal(9, 0.25);
  EXPECT_EQ(steadiness(times, equal).since, 0.0);
  expect_error(
      [&] {
        (void)steadiness({times.data(), 8}, {equal.data(), 8});
      },
      {"8 values", "at least 9"});
}

TEST(DepthDrift, IsSteadyAfterAKnock) {
  const Steadiness found = judged(1, [](double minutes) { return minutes < 20 ? 0 : 0.1; });
  ASSERT_TRUE(found.since);
  EXPECT_NEAR(*found.since, 20, 0.5);
}

TEST(DepthDrift, TellsAShiftFromATilt) {
  const Size size{64, 48};
  Image<float> before(size, 500), shifted(size, 500.25F), tilted(size);
  for_each_pixel_in_order(size, [&](int column, int row) {
    tilted(column, row) = static_cast<float>(500 + 0.01 * (column - 31.5));
  });
  // Pixels without a point in one of both do not count.
  std::fill_n(before.begin(), 500, std::numeric_limits<float>::quiet_NaN());
  std::fill_n(shifted.begin() + 2000, 500, std::numeric_limits<float>::quiet_NaN());

  const DepthChange shift = depth_change(before, shifted), tilt = depth_change(before, tilted);
  EXPECT_EQ(shift.mean, 0.25);
  EXPECT_EQ(shift.uneven, 0);
  EXPECT_NEAR(tilt.mean, 0, 0.01);
  // The middles of four equal parts of 0.64 mm.
  EXPECT_NEAR(tilt.uneven, 0.16 * std::sqrt(1.25), 0.01);

  expect_error([&] { (void)depth_change(before, Image<float>({8, 8})); }, {"64x48", "8x8"});
  expect_error(
      [&] {
        (void)depth_change(Image<float>({8, 8}), Image<float>({8, 8}));
      },
      {"only 64 pixels"});
}

}  // namespace slipstream::depth_drift_test
