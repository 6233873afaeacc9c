// The library speaks of settings and operations, see Error; only the program has flags and
// commands.
#include <cctype>
#include <cstddef>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace flag_words_test {
namespace {
namespace fs = std::filesystem;

std::string text_in(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Reads the string literals of a C++ source, neighbours joined as compilers join them.
class LiteralReader {
 public:
  explicit LiteralReader(const std::string& source) : source_(source) {}

  std::vector<std::string> read() {
    while (at_ < source_.size()) {
      const char letter = source_[at_];

      if (begins("//")) {
        skip_past("\n");
      } else if (begins("/*")) {
        skip_past("*/");
      } else if (begins("R\"")) {
        take_raw();
      } else if (letter == '"') {
        take_quoted();
      } else if (letter == '\'') {
        skip_character();
      } else {
        if (std::isspace(static_cast<unsigned char>(letter)) == 0) joins_ = false;
        ++at_;
      }
    }
    return literals_;
  }

 private:
  [[nodiscard]] bool begins(const std::string& what) const {
    return source_.compare(at_, what.size(), what) == 0;
  }

  void skip_past(const std::string& end) {
    const std::size_t found = source_.find(end, at_);
    at_ = found == std::string::npos ? source_.size() : found + end.size();
  }

  /// 'x', '"' or '\''; not the separator of 1'000.
  void skip_character() {
    const bool separates = at_ > 0 && std::isalnum(static_cast<unsigned char>(source_[at_ - 1]));
    at_ += separates ? 1 : source_[at_ + 1] == '\\' ? 4 : 3;
    joins_ = false;
  }

  void take_quoted() {
    std::string literal;
    for (++at_; at_ < source_.size() && source_[at_] != '"'; ++at_) {
      const bool is_escaped = source_[at_] == '\\';  // e.g. a line break; it ends a word
      if (is_escaped) ++at_;
      literal += is_escaped ? ' ' : source_[at_];
    }
    ++at_;
    add(literal);
  }

  /// R"mark(literal)mark".
  void take_raw() {
    const std::size_t open = source_.find('(', at_);
    const std::string close = ")" + source_.substr(at_ + 2, open - at_ - 2) + "\"";
    const std::size_t begin = open + 1, end = source_.find(close, begin);
    at_ = end + close.size();
    add(source_.substr(begin, end - begin));
  }

  void add(const std::string& literal) {
    if (!joins_) literals_.emplace_back();
    literals_.back() += literal;
    joins_ = true;
  }

  const std::string& source_;
  std::size_t at_ = 0;
  bool joins_ = false;  ///< only space and comments since the last literal
  std::vector<std::string> literals_;
};

/// The flags and commands that the source's string literals name.
std::vector<std::string> program_words(const std::string& source, const std::regex& words) {
  std::vector<std::string> named;
  for (const std::string& literal : LiteralReader(source).read()) {
    std::smatch found;
    if (std::regex_search(literal, found, words)) named.push_back(found.str());
  }
  return named;
}

/// "--order", and "slipstream view" with the name of any command in main.cpp.
std::regex flags_and_commands() {
  const std::string source = text_in(fs::path(SLIPSTREAM_SOURCE_FOLDER) / "app" / "main.cpp");
  const std::regex command("\\{\"([a-z]+)\", add_");
  std::string commands;
  for (std::sregex_iterator match(source.begin(), source.end(), command), end; match != end;
       ++match) {
    commands += (commands.empty() ? "" : "|") + match->str(1);
  }

  EXPECT_NE(commands.find("view"), std::string::npos);
  return std::regex("--[a-z][a-z-]*|slipstream (" + commands + ")\\b");
}

TEST(FlagWords, StandInNoMessageOfTheLibrary) {
  const std::regex words = flags_and_commands();
  const fs::path root = SLIPSTREAM_SOURCE_FOLDER;
  int files = 0;

  for (const char* const folder : {"include", "src"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      const std::string path = entry.path().lexically_relative(root).generic_string();
      const fs::path extension = entry.path().extension();
      if ((extension != ".h" && extension != ".cpp")) continue;

      ++files;
      for (const std::string& named : program_words(text_in(entry.path()), words)) {
        ADD_FAILURE() << path << " names '" << named
                      << "': name the setting or operation, see Error";
      }
    }
  }

  EXPECT_GT(files, 300);
}

TEST(FlagWords, AreFoundInStringsOnly) {
  const std::regex words = flags_and_commands();
  const auto found = [&](const std::string& source) { return program_words(source, words); };

  EXPECT_EQ(found("f(\"try --order 2\", 1'000); g('\"', \"use --axis\")"),
            (std::vector<std::string>{"--order", "--axis"}));
  EXPECT_EQ(found("f(\"see slipstream \"  // a comment\n  \"view\")"),
            (std::vector<std::string>{"slipstream view"}));
  EXPECT_EQ(found("R\"x(say \"--low-steps\")x\""), (std::vector<std::string>{"--low-steps"}));

  EXPECT_TRUE(
      found("// \"--order\"\n/* \"--axis\" */ --n; \"`order 2` and a slipstream file\"").empty());
}

}  // namespace
}  // namespace flag_words_test
