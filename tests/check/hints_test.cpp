// What is proposed, and how: see broken_scans_test.cpp for everything that can go wrong.
#include <algorithm>
#include <filesystem>
#include <numeric>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "check/fit.h"
#include "check/frame_orders.h"
#include "slipstream/check.h"
#include "slipstream/gray_code.h"
#include "slipstream/phase_shifting.h"
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

TEST(Hints, RealCodesGiveOriginAndDirection) {
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

TEST(Hints, RealMicroPhaseShiftingGivesOriginAndDirection) {
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

// Exchanged steps of an oblique sinusoid leave its carrier in the phase, which rises steadily along
// the picture.
TEST(Hints, NameSwappedStepsOfObliqueSinusoids) {
  const VirtualWorld world =
      virtual_world({.scene = "sphere", .camera = {320, 240}, .world = "bench", .seed = 3});
  const Strategy strategy = ModulatedPhaseShifting{};
  Scan scan{.frames = take_scan(world.scanner, world.scene, pattern_set(strategy, Axis::x),
                                world.photometry)
                          .frames,
            .sequence = {strategy, Axis::x, {}, world.scanner.projector.size},
            .scanner = as_calibrated(world)};
  EXPECT_EQ(advice_for(scan), "");

  const Order swapped{0, 1, 2, 3, 4, 5, 6, 7, 8, 10, 9, 11};
  taken_in_order(swapped)(scan);
  EXPECT_NE(advice_for(scan).find(fmt::format("`order {}`", fmt::join(swapped, ","))),
            std::string::npos)
      << advice_for(scan);
}

/// The advice for a scan of one strategy that is read as another.
std::string advice_if_read_as(const Strategy& shown, const Strategy& read) {
  Scan scan = right_scan("statue", shown);
  scan.sequence.strategy = read;
  return advice_for(scan);
}

// As a loop over the steps around one over the bands takes them.
TEST(Hints, NameStepsOfAllBandsInTurn) {
  for (const int bands : {2, 3, 4}) {
    std::vector<double> periods{1, 6, 30, 90};
    periods.resize(static_cast<std::size_t>(bands));
    Scan scan = right_scan(
        "statue", make_strategy("multi-frequency", {{"steps", "4"}, {"periods", periods}}));

    Order taken, put_right;
    for (int n = 0; n < 4 * bands; ++n) {
      taken.push_back(n % bands * 4 + n / bands);
      put_right.push_back(n % 4 * bands + n / 4);
    }
    taken_in_order(taken)(scan);
    EXPECT_NE(advice_for(scan).find(fmt::format("try `order {}`", fmt::join(put_right, ","))),
              std::string::npos)
        << advice_for(scan);
  }
}

// As numpy.linspace(0, 2 pi, N) gives them.
TEST(Hints, NameShiftsThatCountBothEnds) {
  const auto shown = [](const char* shifts) {
    return make_strategy("dual-frequency", {{"shifts", shifts}, {"high", 16}, {"low", 1}});
  };
  const auto read = [](int steps) {
    return make_strategy("dual-frequency", {{"steps", steps}, {"high", 16}, {"low", 1}});
  };
  EXPECT_EQ(advice_if_read_as(shown("0,90,180,270,360"), read(5)), "try `shifts 0,90,180,270,360`");
  EXPECT_EQ(advice_if_read_as(shown("0,120,240,360"), read(4)), "try `shifts 0,120,240,360`");
}

// A code's edges lie between two projector pixels, half a pixel before the stripe's first one.
TEST(Hints, RoundOriginsToAStepOfTheShifts) {
  const auto with_origin = [](int steps, double periods, const char* origin) {
    return make_strategy("gray-phase",
                         {{"steps", steps}, {"periods", periods}, {"origin", origin}});
  };
  EXPECT_TRUE(advice_if_read_as(with_origin(8, 32, "-0.785398"), with_origin(8, 32, "0"))
                  .starts_with("try `origin -0.7854`"));
  EXPECT_TRUE(advice_if_read_as(with_origin(18, 40, "-0.349066"), with_origin(18, 40, "0"))
                  .starts_with("try `origin -0.34907`"));
  EXPECT_TRUE(advice_if_read_as(with_origin(4, 32, "3.14159"), with_origin(4, 32, "0"))
                  .starts_with("try `origin 3.1416`"));
  // Not near any: a value as inexact as it was measured is not proposed.
  EXPECT_EQ(advice_if_read_as(with_origin(4, 32, "0.7"), with_origin(4, 32, "0")).find("`origin"),
            std::string::npos);
}

// An error of d turns moves the relation of 7 periods to 1 by 6 d: no whole number, and no quarter.
TEST(Hints, FindOriginsByTheRelationOfTheBands) {
  const auto with_origin = [](const char* origin) {
    return make_strategy("dual-frequency",
                         {{"steps", 5}, {"high", 7}, {"low", 1}, {"origin", origin}});
  };
  EXPECT_NE(advice_if_read_as(with_origin("1.25664"), with_origin("0")).find("`origin 1.2566`"),
            std::string::npos);
}

// The phase that is added to the measured one and an origin that is as much less are the same.
TEST(Hints, OriginThatFitsMakesUpForThePhase) {
  const double phase = 2, shift = 0.7;
  const Finding finding = wrong_origin(make_strategy("gray-phase", {{"origin", 0.2}}), shift);
  const double fits = finding.evidence.at(0).value;
  EXPECT_NEAR(unshifted_phase({.origin = fits}, phase),
              unshifted_phase({.origin = 0.2}, phase) + shift, 1e-9);
}

// Stripes of 40 pixels number periods of 1280 / 36 pixels: the difference grows along the field.
TEST(Hints, ProposeNoOriginForStripesOfAnotherWidth) {
  const Scan of_periods = right_scan("statue", GrayPhase{.periods = 36, .bits = 6});
  const Scan of_stripes = right_scan("statue", GrayPhase{.periods = 35.6, .bits = 6});
  Scan scan = of_periods;
  Pictures pictures = pictures_of(of_periods);
  const Pictures code = pictures_of(of_stripes);
  for (std::size_t n = 4; n < pictures.size(); ++n) pictures[n] = code[n];
  scan.frames = FrameSet(std::move(pictures));

  const std::vector<Finding> findings = check_scan(scan).findings;
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings.front().severity, Severity::doubtful) << text_of(findings.front());
  EXPECT_NE(causes_of(findings.front()).find("not as wide as a period"), std::string::npos)
      << text_of(findings.front());
}

// Stripes of a width of their own are given: with another width most fringe orders are wrong.
TEST(Hints, TakeNoCodeOfAnotherWidthThanGiven) {
  Scan scan = right_scan("statue", GrayPhase{.periods = 16, .stripes = 64});
  for (const double stripes : {61.0, 60.95}) {
    scan.sequence.strategy = GrayPhase{.periods = 16, .stripes = stripes};
    const std::vector<Finding> findings = check_scan(scan).findings;
    ASSERT_FALSE(findings.empty()) << stripes;
    EXPECT_EQ(findings.front().severity, Severity::wrong) << text_of(findings.front());
    EXPECT_TRUE(blames(findings.front(), CauseKind::pattern_settings)) << text_of(findings.front());
  }
}

/// The scan as of a region of the sensor that was set after the calibration.
Scan cropped_scan(const Strategy& strategy, int left, int top) {
  Scan scan = right_scan("board", strategy);
  Pictures pictures = pictures_of(scan);
  constexpr Size size{440, 320};
  for (Image<std::uint8_t>& picture : pictures) {
    Image<std::uint8_t> part(size);
    for (int row = 0; row < size.height; ++row) {
      std::copy_n(picture.row(row + top) + left, size.width, part.row(row));
    }
    picture = std::move(part);
  }
  scan.frames = FrameSet(std::move(pictures));
  scan.scanner->camera.size = size;
  return scan;
}

// Frames that fit by themselves are right, whatever a scanner file for other pictures says.
TEST(Hints, ProposeNoSettingsForCroppedPictures) {
  for (const auto& [left, top] : {std::pair{100, 80}, std::pair{0, 0}, std::pair{190, 150}}) {
    for (const char* const name : {"dual-frequency", "gray-phase", "multi-frequency"}) {
      const Scan scan = cropped_scan(make_strategy(name, {}), left, top);
      EXPECT_EQ(advice_for(scan).find("try `"), std::string::npos)
          << name << ", " << left << ": " << advice_for(scan);
    }
  }
}

// Bands whose fringes the camera cannot see say nothing of the light.
TEST(Hints, ProposeNoMoreLightForNarrowFringes) {
  Scan scan = right_scan("board", DualFrequency{.steps = 3, .high = 240});
  EXPECT_EQ(advice_for(scan).find("exposure"), std::string::npos) << advice_for(scan);
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

TEST(Hints, FrameOrdersInterleaveBandsThatBeginAfterAnotherFrame) {
  std::vector<Order> orders;
  const std::vector<StepRun> runs{{1, 4}, {6, 4}};

  add_several_runs(as_captured(10), runs, collect_in(orders));
  ASSERT_EQ(orders.size(), 3U);
  EXPECT_EQ(orders[1], (Order{0, 1, 3, 6, 8, 5, 2, 4, 7, 9}));
  EXPECT_EQ(orders[2], (Order{0, 2, 4, 7, 9, 5, 1, 3, 6, 8}));
}

TEST(Hints, FrameOrdersPutInversesAfterTheBitsWhateverTheirFrames) {
  std::vector<Order> orders;
  const Code code{.stripes = 8, .frames = {1, 3, 9}, .inverses = {0, 2, 8}};

  add_code_orders(as_captured(10), code, collect_in(orders));
  ASSERT_EQ(orders.size(), 3U);
  EXPECT_EQ(orders[2], (Order{3, 0, 8, 1, 4, 5, 6, 7, 9, 2}));
}

TEST(Hints, FitNamesNoRelationThatNoiseHides) {
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
