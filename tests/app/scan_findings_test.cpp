// How the program reports diagnostics.
#include <gtest/gtest.h>

#include "app/output.h"
#include "slipstream/error.h"

namespace slipstream::app::scan_findings_test {

const Finding dim{.what = "the frames are dim"};
const Finding rotated{.kind = FindingKind::fringe_orders_disagree,
                      .severity = Severity::wrong,
                      .what = "the bands disagree",
                      .evidence = {{"agreement", 0.25}},
                      .causes = {{CauseKind::frame_order, "frames 0 to 2 are rotated by one"}},
                      .remedies = {try_setting("order", "2,0,1,3,4,5")}};
const Finding dark{.severity = Severity::wrong, .what = "no frame has light in it"};

std::string refusal_of(const std::vector<Finding>& findings, bool anyway = false) {
  Output output(false);
  try {
    refuse_or_warn({.findings = findings}, "scan", anyway, output);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(ScanFindings, AllThatIsWrongIsRefusedInOneLine) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(refusal_of({dim, rotated, dark}),
            "scan: the bands disagree (agreement = 0.25); likely frames 0 to 2 are rotated by one; "
            "try `order 2,0,1,3,4,5` | no frame has light in it | the frames are dim");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "");
}

TEST(ScanFindings, WhatIsDoubtfulIsWarnedOfAndAnywayAllIs) {
  testing::internal::CaptureStderr();
  EXPECT_EQ(refusal_of({dim}), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "warning: scan: the frames are dim\n");
  testing::internal::CaptureStderr();
  EXPECT_EQ(refusal_of({dim, dark}, true), "");
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "warning: scan: the frames are dim\nwarning: scan: no frame has light in it\n");
  EXPECT_EQ(refusal_of({}), "");
}

TEST(ScanFindings, RepairsAreSaid) {
  testing::internal::CaptureStdout();
  Output output(false);
  refuse_or_warn({.repairs = {"frames put in the order 1,2,0"}}, "scan", false, output);
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "scan: frames put in the order 1,2,0\n");
}

TEST(ScanFindings, OnlyWhatIsWrongMakesACloudDoubted) {
  EXPECT_EQ(doubts({dim, dark}), (std::vector<std::string>{"doubted: no frame has light in it"}));
  EXPECT_TRUE(doubts({dim}).empty());
}

TEST(ScanFindings, GammaIsLeftOutWhereItIsMeasured) {
  const Finding gamma{.what = "ripples", .causes = {{CauseKind::gamma, "the projector's gamma"}}};
  EXPECT_EQ(without_cause({dim, gamma, dark}, CauseKind::gamma), (std::vector<Finding>{dim, dark}));
}

TEST(ScanFindings, JsonHasAllOfAFinding) {
  const nlohmann::json expected{
      {"kind", "fringe-orders-disagree"},
      {"what", "the bands disagree"},
      {"evidence", {{"agreement", 0.25}}},
      {"quantities", {{{"name", "agreement"}, {"value", 0.25}}}},
      {"likely", "frames 0 to 2 are rotated by one"},
      {"causes", {{{"kind", "frame-order"}, {"text", "frames 0 to 2 are rotated by one"}}}},
      {"try", "try `order 2,0,1,3,4,5`"},
      {"remedies",
       {{{"text", "try `order 2,0,1,3,4,5`"}, {"settings", {{"order", "2,0,1,3,4,5"}}}}}},
      {"refused", true}};
  EXPECT_EQ(nlohmann::json(rotated), expected);

  const nlohmann::json none = dim;
  EXPECT_EQ(none["refused"], false);
  EXPECT_TRUE(none["evidence"].is_object());
}

TEST(ScanFindings, LiveFindingsEachIsToldOnceWhenItBeginsAndWhenItEnds) {
  std::vector<LiveFinding> told;
  Output output(true);  // text goes to stderr
  const auto news = [&](const std::vector<LiveFinding>& findings) {
    testing::internal::CaptureStderr();
    tell_news(findings, told, output);
    return testing::internal::GetCapturedStderr();
  };
  EXPECT_EQ(news({}), "");
  EXPECT_EQ(news({{dim, 7, {}}}), "warning: frames: the frames are dim\n");
  EXPECT_EQ(news({{dim, 7, {}}}), "");
  EXPECT_EQ(news({{dim, 7, 19}}), "frames: the frames are dim: ended after 12 frames\n");
  EXPECT_EQ(news({{dim, 7, 19}}), "");
  // Began and ended between two calls.
  EXPECT_EQ(news({{dim, 7, 19}, {dim, 30, 34}}),
            "warning: frames: the frames are dim\n"
            "frames: the frames are dim: ended after 4 frames\n");
  const nlohmann::json listed = std::vector<LiveFinding>{{dim, 7, 19}, {dim, 30, {}}};
  EXPECT_EQ(listed[0]["begin"], 7);
  EXPECT_EQ(listed[0]["end"], 19);
  EXPECT_TRUE(listed[1]["end"].is_null());
}

}  // namespace slipstream::app::scan_findings_test
