// What is proposed, and how: see broken_table_test.cpp for everything that can go wrong.
#include <algorithm>
#include <filesystem>
#include <numeric>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "check/fit.h"
#include "check/frame_orders.h"
#include "slipstream/check.h"
#include "slipstream/gray_code.h"
#include "slipstream/virtual_world.h"
#include "tests/check/mistakes.h"
#include "tests/check/real_sets.h"

namespace slipstream::hints_test {

namespace fs = std::filesystem;

Scan right_scan(const std::string& scene, const Strategy& strategy) {
  const VirtualWorld world =
      virtual_world({.scene = scene, .camera = {640, 480}, .world = "ideal", .seed = 3});
  return {.frames = take_scan(world.scanner, world.scene, pattern_set(strategy, Axis::x),
                              world.photometry)
                        .frames,
          .sequence = {strategy, Axis::x, {}, world.scanner.projector.size},
          .scanner = as_calibrated(world)};
}

using Order = std::vector<int>;

std::string advice_for(const Scan& scan) {
  std::string text;
  for (const Finding& finding : check_scan(scan).findings) text += remedies_of(finding);
  return text;
}

TEST(RealCodes, GiveOriginAndDirection) {
  const fs::path folder = shared_data() / "slmaster-mono";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const auto names = names_of(18, [](int n) { return fmt::format("frame_{:02}.png", n); });
  Scan scan = real_scan(folder, names, GrayPhase{.steps = 12}, {1920, 1080});
  EXPECT_TRUE(advice_for(scan).starts_with("try `backwards` `origin 3.1416`")) << advice_for(scan);
  scan.sequence.strategy = GrayPhase{.steps = 12, .shifts = {3.1416, true}};
  EXPECT_EQ(advice_for(scan), "");
  taken_in_order({0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 17, 16})(scan);
  EXPECT_TRUE(
      advice_for(scan).starts_with("try `order 0,1,2,3,4,5,6,7,8,9,10,11,12,13,14,15,17,16`"))
      << advice_for(scan);
}

TEST(RealMicroPhaseShifting, GivesOriginAndDirection) {
  const fs::path folder = shared_data() / "microps-waxbowl" / "32-08";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const auto names = names_of(10, [](int n) { return fmt::format("Frame{:03}.png", n + 1); });
  const std::vector<double> periods{23.0366, 21.9441, 20.9257, 22.3948,
                                    23.9459, 19.7955, 32.2165, 21.3583};
  Scan scan = real_scan(folder, names, MicroPhaseShifting{.periods = periods}, {1024, 768});
  EXPECT_TRUE(advice_for(scan).starts_with("try `backwards`")) << advice_for(scan);
  scan.sequence.strategy = MicroPhaseShifting{.periods = periods, .shifts = {0, true}};
  EXPECT_EQ(advice_for(scan), "");
  scan.sequence.strategy = MicroPhaseShifting{.periods = periods, .shifts = {1, true}};
  EXPECT_TRUE(advice_for(scan).starts_with("try `origin 0`")) << advice_for(scan);
}

// With the order in force a hint gives the whole order; the stored order is no order.
TEST(Hints, AreComposedWithTheOrderInForce) {
  Scan scan = right_scan("statue", GrayPhase{});
  const Order wrong{0, 1, 2, 3, 5, 4, 6, 7, 8, 9};
  taken_in_order(wrong)(scan);
  EXPECT_EQ(advice_for(scan), "try `order 0,1,2,3,5,4,6,7,8,9`");
  scan.order = wrong;
  EXPECT_EQ(advice_for(scan), "omit `order`");
}

TEST(Hints, EvidenceIsBeyondItsLimit) {
  Scan scan = right_scan("statue", GrayPhase{});
  copied(0, 1)(scan);

  const std::vector<Finding> findings = check_scan(scan).findings;
  const auto repeated = std::ranges::find(findings, FindingKind::repeated_frame, &Finding::kind);
  ASSERT_NE(repeated, findings.end());

  const Evidence& share = repeated->evidence.front();
  EXPECT_GT(share.value, share.limit.value());
}

/// The frames in the order of capture.
Order as_captured(int frames) {
  Order order(static_cast<std::size_t>(frames));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

/// Collects orders, all of which must contain each frame once.
AddOrder collect_in(std::vector<Order>& orders) {
  return [&](const FrameOrder& order, const std::string& likely) {
    EXPECT_TRUE(std::ranges::is_permutation(order, as_captured(10))) << likely;
    orders.push_back(order);
  };
}

TEST(FrameOrders, InterleaveBandsThatBeginAfterAnotherFrame) {
  std::vector<Order> orders;
  const std::vector<StepRun> runs{{1, 4}, {6, 4}};

  add_several_runs(as_captured(10), runs, collect_in(orders));
  ASSERT_EQ(orders.size(), 3U);
  EXPECT_EQ(orders[1], (Order{0, 1, 3, 6, 8, 5, 2, 4, 7, 9}));
  EXPECT_EQ(orders[2], (Order{0, 2, 4, 7, 9, 5, 1, 3, 6, 8}));
}

TEST(FrameOrders, PutInversesAfterTheBitsWhateverTheirFrames) {
  std::vector<Order> orders;
  const Code code{.stripes = 8, .frames = {1, 3, 9}, .inverses = {0, 2, 8}};

  add_code_orders(as_captured(10), code, collect_in(orders));
  ASSERT_EQ(orders.size(), 3U);
  EXPECT_EQ(orders[2], (Order{3, 0, 8, 1, 4, 5, 6, 7, 9, 2}));
}

TEST(Fit, NamesNoRelationThatNoiseHides) {
  const BandRelation hidden{.agreement = 0.1, .offset = 0.4, .noise = 0.2};
  const BandRelation off{.agreement = 0.9, .offset = 0.2, .noise = 0.9};
  const BandRelation right{.agreement = 0.9, .offset = 0.01, .noise = 0.9};

  Fit fit;
  fit.frames.relations = {hidden, right};
  EXPECT_EQ(fit.worst_relation(), nullptr);

  fit.frames.relations = {right, off, hidden};
  EXPECT_EQ(fit.worst_relation(), &fit.frames.relations[1]);
}

}  // namespace slipstream::hints_test
