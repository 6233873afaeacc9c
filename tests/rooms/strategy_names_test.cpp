// Only the room codes names individual strategies; all other code reads their layouts.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <string>

#include <gtest/gtest.h>

namespace {
namespace fs = std::filesystem;

TEST(StrategyNames, StandInNoRoomButTheirOwn) {
  const std::regex name(
      "PhaseMeasuring|DualFrequency|PhaseChannelMultiplexing|\"(pmp|dual-frequency|pcmp)\"");
  const std::regex of_codes(
      "src/codes/.*|include/slipstream/"
      "(one_frame|phase_channel_multiplexing|phase_shifting|strategy)"
      "\\.h");
  const fs::path sources = fs::path(SLIPSTREAM_SOURCE_FOLDER);
  int files = 0;
  for (const char* const folder : {"include", "src", "app"}) {
    for (const auto& entry : fs::recursive_directory_iterator(sources / folder)) {
      const std::string path = entry.path().lexically_relative(sources).generic_string();
      if (!entry.is_regular_file() || std::regex_match(path, of_codes)) continue;
      ++files;
      std::ifstream file(entry.path());
      const std::string text(std::istreambuf_iterator<char>(file), {});
      std::smatch found;
      EXPECT_FALSE(std::regex_search(text, found, name)) << path << ": " << found[0];
    }
  }
  EXPECT_GT(files, 300);
}

}  // namespace
