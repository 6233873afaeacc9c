#include "slipstream/finding.h"

#include <algorithm>
#include <fstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace slipstream::finding_test {

TEST(Finding, IsOneLineForPeople) {
  const Finding finding{
      .what = "the bands disagree about the phase",
      .evidence = {{"agreement", 0.123456}, {"median depth", 812.4, "mm"}},
      .causes = {{CauseKind::frame_order, "frames 0 to 2 are rotated by one"},
                 {CauseKind::gamma, "the projector's gamma"}},
      .remedies = {try_setting("order", "2,0,1,3,4,5"), {"measure it with `calibrate_gamma()`"}},
      .remark = "all of these fit, so verify the result",
      .subject = "camera 2"};

  EXPECT_EQ(text_of(finding),
            "camera 2: the bands disagree about the phase (agreement = 0.123, median depth, mm = "
            "812); likely frames 0 to 2 are rotated by one, or the projector's gamma; try `order "
            "2,0,1,3,4,5`; or measure it with `calibrate_gamma()`; all of these fit, so verify the "
            "result");
  EXPECT_EQ(text_of({.what = "no light"}), "no light");
}

TEST(Finding, RemedyIsSettingsAndWords) {
  const Remedy remedy = change_settings(
      "try", {{"backwards", "true"}, {"plain", "false"}, {"origin", "1.57"}, {"order", ""}});

  EXPECT_EQ(remedy.text, "try `backwards` `no_plain` `origin 1.57` `order`");
  ASSERT_EQ(remedy.settings.size(), 4U);
  EXPECT_EQ(remedy.settings[2], (SettingChange{"origin", "1.57"}));
}

TEST(Finding, RefusesWhereOneIsWrong) {
  EXPECT_FALSE(any_wrong({}));

  const std::vector<Finding> doubtful{{.what = "a"}};
  EXPECT_FALSE(any_wrong(doubtful));

  const std::vector<Finding> wrong{{.what = "a"}, {.severity = Severity::wrong, .what = "b"}};
  EXPECT_TRUE(any_wrong(wrong));
  EXPECT_EQ(gravest_first(wrong).front().what, "b");
}

TEST(Finding, IsTheSameWithOtherNumbersButNotOfAnotherFrame) {
  const Finding black{.kind = FindingKind::partly_black_frame,
                      .what = "frame 3 is black",
                      .evidence = {{"share", 0.2}},
                      .frames = {3}};

  Finding later = black;
  later.evidence = {{"share", 0.4}};
  EXPECT_TRUE(is_same(black, later));

  Finding other = black;
  other.frames = {4};
  EXPECT_FALSE(is_same(black, other));

  // The frame that changes most is another one at each look.
  const Finding flickering{.kind = FindingKind::changing_light, .frames = {1}};
  EXPECT_TRUE(is_same(flickering, {.kind = FindingKind::changing_light}));

  other = black;
  other.subject = "camera 2";
  EXPECT_FALSE(is_same(black, other));
}

/// The identifiers in the table of the page's section, in its order.
std::vector<std::string> listed_under(const std::string& heading) {
  std::ifstream page(std::string(SLIPSTREAM_SOURCE_FOLDER) + "/docs/reference/findings.md");
  std::vector<std::string> listed;
  bool is_here = false;

  for (std::string line; std::getline(page, line);) {
    if (line.starts_with("## ")) is_here = line == "## " + heading;
    if (is_here && line.starts_with("| `")) listed.push_back(line.substr(3, line.find('`', 3) - 3));
  }

  return listed;
}

/// The names of all kinds up to the last one, in the order of the enumeration.
template <class Kind>
std::vector<std::string> names_up_to(Kind last) {
  std::vector<std::string> names;
  for (int i = 0; i <= static_cast<int>(last); ++i) {
    names.emplace_back(name_of(static_cast<Kind>(i)));
  }
  return names;
}

/// The enumerators that the header declares, in order, with dashes: "frame-order".
std::vector<std::string> declared_in(const std::string& enumeration) {
  std::ifstream header(std::string(SLIPSTREAM_SOURCE_FOLDER) + "/include/slipstream/finding.h");
  std::vector<std::string> declared;
  bool is_here = false;

  for (std::string line; std::getline(header, line);) {
    if (line.starts_with("enum class ")) is_here = line == "enum class " + enumeration + " {";
    if (line.starts_with("}")) is_here = false;
    if (!is_here || !line.starts_with("  ") || line.starts_with("  //")) continue;
    std::string name = line.substr(2, line.find(',') - 2);
    std::ranges::replace(name, '_', '-');
    declared.push_back(name);
  }

  return declared;
}

// Scripts depend on them: each is its enumerator, no two are alike, and all are on the page.
TEST(Finding, KindsAndCausesHaveIdentifiers) {
  const auto findings = names_up_to(FindingKind::inaccurate_scanner);
  EXPECT_EQ(findings, declared_in("FindingKind"));
  EXPECT_EQ(findings, listed_under("Kinds"));

  const auto causes = names_up_to(CauseKind::inaccurate_corners);
  EXPECT_EQ(causes, declared_in("CauseKind"));
  EXPECT_EQ(causes, listed_under("Causes"));

  EXPECT_EQ(name_of(FindingKind::fringe_orders_disagree), "fringe-orders-disagree");
  EXPECT_EQ(name_of(FindingKind::inaccurate_scanner), "inaccurate-scanner");
  EXPECT_EQ(name_of(CauseKind::gamma), "gamma");
}

}  // namespace slipstream::finding_test
