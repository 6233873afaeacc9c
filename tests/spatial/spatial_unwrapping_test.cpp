#include "slipstream/spatial_unwrapping.h"

#include <cmath>
#include <vector>

#include <gtest/gtest.h>
#include <lemon/network_simplex.h>
#include <lemon/smart_graph.h>
#include <rapidcheck/gtest.h>

#include "slipstream/error.h"
#include "spatial/methods.h"
#include "tests/spatial/known_phase.h"

namespace slipstream::spatial_unwrapping_test {

constexpr double period = 2 * std::numbers::pi;
constexpr float nothing = std::numeric_limits<float>::quiet_NaN();

class SpatialUnwrappingEachMethod : public testing::TestWithParam<std::string> {};

TEST_P(SpatialUnwrappingEachMethod, UnwrapsASmoothSurface) {
  const Size size{96, 80};
  const KnownPhase known =
      known_phase(size, 0.05, [&](double x, double y) { return 3 * hills(size, x, y); });
  const auto unwrapped = unwrap_in_space(known.wrapped, {}, GetParam());
  EXPECT_EQ(right_share(known, unwrapped.phase), 1);
  ASSERT_EQ(unwrapped.regions.size(), 1U);
  EXPECT_EQ(unwrapped.phase(0, 0), known.wrapped(0, 0));
}

TEST_P(SpatialUnwrappingEachMethod, TakesEmptySmallAndVoidPictures) {
  EXPECT_TRUE(unwrap_in_space(Image<float>(), {}, GetParam()).regions.empty());
  EXPECT_TRUE(unwrap_in_space(Image<double>({0, 5}), {}, GetParam()).phase.empty());
  const auto one = unwrap_in_space(Image<double>({1, 1}, 7.5), {}, GetParam());
  EXPECT_EQ(one.phase(0, 0), 7.5);
  EXPECT_EQ(one.region(0, 0), 1);
  for (const Size size : {Size{1, 40}, Size{40, 1}, Size{2, 2}}) {
    const KnownPhase known = known_phase(size, 0, [](double x, double y) { return x + y; });
    EXPECT_EQ(right_share(known, unwrap_in_space(known.wrapped, {}, GetParam()).phase), 1)
        << text_of(size);
  }
  const auto none = unwrap_in_space(Image<float>({9, 7}, nothing), {}, GetParam());
  EXPECT_TRUE(none.regions.empty());
  EXPECT_EQ(std::count(none.region.begin(), none.region.end(), 0), 63);
}

/// Any phase with any mask: noise, or a surface with some.
KnownPhase any_phase() {
  const Size size{*rc::gen::inRange(1, 24), *rc::gen::inRange(1, 24)};
  const double noise = *rc::gen::inRange(0, 30) * 0.1, slope = *rc::gen::inRange(-20, 21) * 0.1;
  const int kept = *rc::gen::inRange(0, 101);
  std::mt19937 random(*rc::gen::arbitrary<std::uint32_t>());
  return known_phase(size, noise, [&](double x, double y) {
    return static_cast<int>(random() % 100) >= kept ? nothing : slope * (x + 0.5 * y);
  });
}

/// What the least change of the steps costs, by LEMON's network simplex; closed edges cost nothing.
long least_cost(const WrappedCycles& wrapped) {
  const EdgeSteps steps = edge_steps(wrapped.cycles);
  const Image<float> weights = smoothness(wrapped);
  const auto [width, height] = steps.size();
  const Image<int> charges = charges_of(steps);
  lemon::SmartDigraph graph;
  for (std::size_t i = 0; i < charges.pixel_count(); ++i) graph.addNode();
  lemon::SmartDigraph::NodeMap<int> supplies(graph);
  for (int i = 0; i < static_cast<int>(charges.pixel_count()); ++i) {
    supplies[graph.nodeFromId(i)] = charges.begin()[i];
  }
  std::vector<int> costs;
  const auto connect = [&](int first, int second, int less, int more) {
    graph.addArc(graph.nodeFromId(first), graph.nodeFromId(second));
    graph.addArc(graph.nodeFromId(second), graph.nodeFromId(first));
    costs.insert(costs.end(), {less, more});
  };
  const auto cross = [&](bool open, int first, int second, int from, int to) {
    connect(first, second, open ? cost_of_change(wrapped, weights, from, to, -1) : 0,
            open ? cost_of_change(wrapped, weights, from, to, 1) : 0);
  };
  const int wide = width + 1;
  for (int x = 0; x < width; ++x) connect(x, x + 1, 0, 0);
  for (int y = 0; y < height; ++y) {
    connect(y * wide, (y + 1) * wide, 0, 0);
    for (int x = 0; x < width; ++x) {
      const int at = y * width + x, after = (y + 1) * wide + x + 1;
      cross(steps.right(x, y) != EdgeSteps::closed, after, after - wide, at, at + 1);
      cross(steps.down(x, y) != EdgeSteps::closed, after - 1, after, at, at + width);
    }
  }
  lemon::SmartDigraph::ArcMap<int> cost(graph);
  for (int i = 0; i < static_cast<int>(costs.size()); ++i) {
    cost[graph.arcFromId(i)] = costs[static_cast<std::size_t>(i)];
  }
  lemon::NetworkSimplex<lemon::SmartDigraph, int, long> simplex(graph);
  simplex.supplyMap(supplies).costMap(cost).run();
  return simplex.totalCost();
}

long cost_of(const WrappedCycles& wrapped, const Image<int>& order) {
  const EdgeSteps steps = edge_steps(wrapped.cycles);
  const Image<float> weights = smoothness(wrapped);
  long cost = 0;
  for (int at = 0; at < static_cast<int>(order.pixel_count()); ++at) {
    for (const bool down : {false, true}) {
      const int to = at + (down ? order.width() : 1);
      const int step = (down ? steps.down : steps.right).begin()[at];
      if (step == EdgeSteps::closed) continue;
      const int changed = order.begin()[to] - order.begin()[at] - step;
      if (changed == 0) continue;
      cost += std::abs(changed) * cost_of_change(wrapped, weights, at, to, changed > 0 ? 1 : -1);
    }
  }
  return cost;
}

RC_GTEST_PROP(SpatialUnwrappingFlow, CostsAsLittleAsANetworkSimplex, ()) {
  WrappedCycles wrapped{any_phase().wrapped, {}};
  for (float& cycle : wrapped.cycles) cycle /= static_cast<float>(period);
  RC_ASSERT(cost_of(wrapped, orders_by_flow(wrapped).order) == least_cost(wrapped));
}

RC_GTEST_PROP(SpatialUnwrappingAnyMethod, AddsWholePeriodsAndNumbersRegions, ()) {
  const KnownPhase known = any_phase();
  const auto methods = spatial_unwrappings();
  const auto place = *rc::gen::inRange<std::size_t>(0, methods.size());
  Image<float> quality;
  if (*rc::gen::arbitrary<bool>()) {
    quality = Image<float>(known.wrapped.size());
    float level = -1;
    for (float& each : quality) each = level = level > 3 ? -1 : level + 0.37F;
  }
  const auto unwrapped = unwrap_in_space(known.wrapped, quality, methods[place].name);
  std::vector<std::size_t> pixels(unwrapped.regions.size());
  for (std::size_t i = 0; i < known.wrapped.pixel_count(); ++i) {
    const float phase = known.wrapped.begin()[i];
    const int region = unwrapped.region.begin()[i];
    RC_ASSERT((region == 0) == std::isnan(phase));
    RC_ASSERT(std::isnan(unwrapped.phase.begin()[i]) == std::isnan(phase));
    if (region == 0) continue;
    const double periods = (unwrapped.phase.begin()[i] - phase) / period;
    RC_ASSERT(std::abs(periods - std::rint(periods)) < 1e-5);
    ++pixels.at(static_cast<std::size_t>(region - 1));
  }
  for (std::size_t n = 0; n < pixels.size(); ++n) {
    RC_ASSERT(pixels[n] == unwrapped.regions[n].pixels);
    if (n > 0) RC_ASSERT(pixels[n] <= pixels[n - 1]);
  }
}

TEST_P(SpatialUnwrappingEachMethod, KeepsApartWhatNothingConnects) {
  const Size size{64, 48};
  const KnownPhase known = known_phase(size, 0, [&](double x, double y) {
    return std::abs(x - 40) < 1 ? nothing : 0.4 * x + 0.1 * y + (x > 40 ? 9 * period : 0);
  });
  auto unwrapped = unwrap_in_space(known.wrapped, {}, GetParam());
  ASSERT_EQ(unwrapped.regions.size(), 2U);
  EXPECT_EQ(unwrapped.region(3, 3), 1);
  EXPECT_EQ(unwrapped.region(40, 3), 0);
  EXPECT_EQ(unwrapped.region(50, 3), 2);
  EXPECT_EQ(right_share(known, unwrapped.phase), 1);

  anchor_at(unwrapped, 50, 20, known.truth(50, 20) + 2);
  EXPECT_FALSE(unwrapped.regions[0].anchored);
  EXPECT_TRUE(unwrapped.regions[1].anchored);
  EXPECT_NEAR(unwrapped.phase(63, 47), known.truth(63, 47), 1e-4);

  Image<float> coarse(size, nothing);
  for (int i = 0; i < 20; ++i) coarse(i, i) = known.truth(i, i) + (i % 3 == 0 ? 50 : -1.5F);
  anchor_by(unwrapped, coarse);
  EXPECT_TRUE(unwrapped.regions[0].anchored);
  EXPECT_NEAR(unwrapped.phase(5, 40), known.truth(5, 40), 1e-4);
}

INSTANTIATE_TEST_SUITE_P(Spatial, SpatialUnwrappingEachMethod, testing::ValuesIn([] {
                           std::vector<std::string> names;
                           for (const auto& method : spatial_unwrappings())
                             names.emplace_back(method.name);
                           return names;
                         }()),
                         [](const auto& info) {
                           std::string name = info.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name;
                         });

TEST(SpatialUnwrapping, RefusesWhatIsWrong) {
  const Image<float> phase({4, 3});
  EXPECT_THROW(unwrap_in_space(phase, Image<float>({3, 4})), Error);
  EXPECT_THROW(unwrap_in_space(phase, {}, "qualty"), Error);
  EXPECT_THROW(unwrap_in_space(Image<double>({2, 2}, 1e7)), Error);
  auto unwrapped = unwrap_in_space(phase);
  EXPECT_THROW(anchor_at(unwrapped, 4, 0, 1), Error);
  EXPECT_THROW(anchor_at(unwrapped, 0, 0, nothing), Error);
  EXPECT_THROW(anchor_by(unwrapped, Image<float>({3, 4})), Error);
}

}  // namespace slipstream::spatial_unwrapping_test
