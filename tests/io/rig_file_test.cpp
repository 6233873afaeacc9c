#include "io/rig_file.h"

#include <string>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "slipstream/error.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::rig_file_test {

TEST(RigFile, GivesSettingsOfAllHeadingsInTheirOrder) {
  const std::vector<RigSetting> settings = rig_from(
      "camera:\n  source: 'virtual'\n  motion: [0.2, 0, 0]\nscanner: a b.yaml\n"
      "sequence: {low_steps: 4}\nloop: true\n",
      "rig.yaml");
  ASSERT_EQ(settings.size(), 5U);
  EXPECT_EQ(settings[0].name, "source");
  EXPECT_EQ(settings[0].values, std::vector<std::string>{"virtual"});
  EXPECT_EQ(settings[0].line, 2);
  EXPECT_EQ(settings[1].values, (std::vector<std::string>{"0.2", "0", "0"}));
  EXPECT_EQ(settings[2].values, std::vector<std::string>{"a b.yaml"});
  EXPECT_EQ(settings[3].name, "low-steps");
  EXPECT_EQ(settings[3].line, 5);
  EXPECT_EQ(settings[4].values, std::vector<std::string>{"true"});
}

/// A rig file of one list of that many values, which as many settings repeat.
std::string repeated_list(int count) {
  std::string text = "first: &all [1";
  for (int i = 1; i < count; ++i) text += ",1";
  text += "]\n";
  for (int i = 0; i < count; ++i) text += fmt::format("s{}: *all\n", i);
  return text;
}

TEST(RigFile, AliasesRepeatNoMoreThanTheText) {
  const std::vector<RigSetting> few = rig_from(repeated_list(3), "rig.yaml");
  ASSERT_EQ(few.size(), 4U);
  EXPECT_EQ(few.back().values.size(), 3U);

  // Otherwise the values are the square of the text.
  expect_error([] { (void)rig_from(repeated_list(200), "rig.yaml"); }, {"rig.yaml", "aliases"});
}

TEST(RigFile, RefusesWhatIsNoRigFileInOneLine) {
  const auto expect_refused = [](const std::string& text,
                                 std::initializer_list<std::string> parts) {
    SCOPED_TRACE(text);
    expect_error([&] { (void)rig_from(text, "rig.yaml"); }, parts);
  };
  expect_refused("", {"rig.yaml", "a map of settings"});
  expect_refused("- steps", {"a map of settings"});
  expect_refused("steps: 3\nhigh: [", {"not YAML"});
  expect_refused("steps: 3\nlow:\n", {"line 2", "low", "a value"});
  expect_refused("steps: []", {"line 1", "steps", "empty"});
  expect_refused("steps: [[1]]", {"steps", "a value"});
  expect_refused("a: {b: {c: 1}}", {"line 1", "b", "a value"});
  expect_refused("steps: 3\nsequence:\n  steps: 4", {"line 3", "steps", "twice"});
  expect_refused("low_steps: 3\nlow-steps: 3", {"line 2", "twice"});
  expect_refused("camera: {steps: 3}\ncamera: {}", {"line 2", "camera is set twice"});
  expect_refused("steps: 3\n---\nlow: 4", {"line 3", "second YAML document"});
  expect_refused("? [1, 2]\n: 3", {"name of a setting"});
  expect_refused("a: &x {b: *x}", {"rig.yaml"});
  const TemporaryFolder folder;
  expect_error([&] { (void)read_rig(folder.path() / "none.yaml"); }, {"none.yaml"});
}

RC_GTEST_PROP(RigFile, GivesBackWhatWasWritten, ()) {
  const auto names = *rc::gen::unique<std::vector<std::string>>(
      rc::gen::nonEmpty(rc::gen::container<std::string>(rc::gen::inRange('a', 'z'))));
  std::string text = "{}";
  std::vector<std::string> values;
  if (!names.empty()) text.clear();
  for (std::size_t i = 0; i < names.size(); ++i) {
    values.push_back(std::to_string(*rc::gen::arbitrary<int>()));
    text += (i % 2 == 0
                 ? "\"" + names[i] + "\": " + values[i]
                 : "heading" + std::to_string(i) + ": {\"" + names[i] + "\": " + values[i] + "}") +
            "\n";
  }
  const std::vector<RigSetting> settings = rig_from(text, "rig.yaml");
  RC_ASSERT(settings.size() == names.size());
  for (std::size_t i = 0; i < names.size(); ++i) {
    RC_ASSERT(settings[i].name == names[i]);
    RC_ASSERT(settings[i].values == std::vector<std::string>{values[i]});
  }
}

RC_GTEST_PROP(RigFile, ReadsOrRefusesAnyText, ()) {
  const std::vector<std::string> words{"steps", ": ", "\n",   "  ",   "- ", "[", "]",   "{",   "}",
                                       "&a ",   "*a", "!!x ", "'",    "\"", "#", "...", "---", "? ",
                                       "1e9",   "\t", "|",    "\xff", ",",  "%", "<<"};
  const auto text = *rc::gen::container<std::vector<std::string>>(rc::gen::elementOf(words));
  std::string joined;
  for (const std::string& word : text) joined += word;
  try {
    for (const RigSetting& setting : rig_from(joined, "rig.yaml")) {
      RC_ASSERT(!setting.values.empty());
    }
  } catch (const Error& error) {
    RC_ASSERT(std::string(error.what()).starts_with("rig.yaml: line "));
    RC_ASSERT(std::string(error.what()).find('\n') == std::string::npos);
  }
}

}  // namespace slipstream::rig_file_test
