// The name of a test leads to its file: suites of foo_bar_test.cpp begin with FooBar, all in one
// casing.
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>

#include <gtest/gtest.h>

namespace {
namespace fs = std::filesystem;

/// foo_bar_test as FooBar.
std::string first_words_of(std::string stem) {
  stem.resize(stem.size() - std::string("_test").size());
  std::string words;
  bool begins = true;
  for (const char letter : stem) {
    if (letter != '_') {
      words += begins ? static_cast<char>(std::toupper(letter)) : letter;
    }
    begins = letter == '_';
  }
  return words;
}

TEST(TestNames, BeginWithTheirFile) {
  const std::regex test(
      R"(\n(?:TYPED_|RC_GTEST_)?(?:FIXTURE_)?(?:TEST|PROP)\w*\(\s*(\w+),\s*(\w+))");
  const std::regex sentence("[A-Z][A-Za-z0-9]*");
  int count = 0;

  for (const auto& entry : fs::recursive_directory_iterator(SLIPSTREAM_SOURCE_FOLDER "/tests")) {
    const fs::path& path = entry.path();
    if (!path.filename().string().ends_with("_test.cpp")) continue;

    std::ifstream file(path);
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    const std::string wanted = first_words_of(path.stem());
    for (std::sregex_iterator at(text.begin(), text.end(), test), end; at != end; ++at, ++count) {
      const std::string suite = (*at)[1], name = (*at)[2];
      EXPECT_TRUE(suite.starts_with(wanted))
          << path << ": " << suite << " does not begin with " << wanted;
      EXPECT_TRUE(std::regex_match(name, sentence)) << path << ": " << suite << "." << name;
    }
  }
  EXPECT_GT(count, 1000);
}

}  // namespace
