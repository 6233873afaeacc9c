// The rooms of slipstream/ include only the rooms that CMake lets them link.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace {
namespace fs = std::filesystem;

using Uses = std::map<std::string, std::set<std::string>>;

/// "phase: error image capture", a line for each room.
Uses read_rooms() {
  Uses uses;
  std::ifstream file(SLIPSTREAM_ROOMS_FILE);
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string room;
    if (!(words >> room)) continue;
    room.pop_back();
    uses[room] = {std::istream_iterator<std::string>(words), {}};
  }
  return uses;
}

std::vector<std::string> included(const std::string& source) {
  static const std::regex include("#\\s*include\\s*[<\"]([^>\"]+)[>\"]");
  std::vector<std::string> headers;
  for (std::sregex_iterator match(source.begin(), source.end(), include), end; match != end;
       ++match) {
    headers.push_back((*match)[1]);
  }
  return headers;
}

/// What a source of `room` includes and may not; empty where all is well.
std::vector<std::string> forbidden_includes(const std::string& room, const std::string& source,
                                            const Uses& uses) {
  static const std::set<std::string> heavy_rooms{"calibrate",   "camera",  "io",  "opengl",
                                                 "performance", "project", "view"};
  static const std::regex slipstream_header("slipstream/([a-z_]+)/.*");
  static const std::regex heavy_library(
      "(opencv2|ceres|yaml-cpp|tiny_obj_loader|pugixml|CLI|nlohmann|GLFW|epoxy|imgui|glm|arv).*");
  std::vector<std::string> forbidden;
  for (const std::string& header : included(source)) {
    std::smatch match;
    if (std::regex_match(header, match, slipstream_header)) {
      const std::string used = match[1];
      if (used != room && !uses.at(room).contains(used)) forbidden.push_back(header);
    } else if (std::regex_match(header, heavy_library) && !heavy_rooms.contains(room)) {
      forbidden.push_back(header);
    }
  }
  return forbidden;
}

std::string contents(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Rooms of which CMake does not tell in builds without windows.
bool may_be_off(const std::string& room) {
  static const std::set<std::string> optional{"opengl", "project", "view"};
  return optional.contains(room);
}

TEST(Rooms, IncludeOnlyWhatTheyMay) {
  const Uses uses = read_rooms();
  int files = 0;
  for (const auto& entry :
       fs::recursive_directory_iterator(fs::path(SLIPSTREAM_SOURCE_FOLDER) / "slipstream")) {
    if (!entry.is_regular_file()) continue;
    const std::string room = entry.path().parent_path().filename();
    if (may_be_off(room) && !uses.contains(room)) continue;
    ASSERT_TRUE(uses.contains(room)) << entry.path() << " is in no room that CMake knows";
    for (const std::string& header : forbidden_includes(room, contents(entry.path()), uses)) {
      ADD_FAILURE() << entry.path() << " includes " << header << ", which " << room << " may not";
    }
    ++files;
  }
  EXPECT_GT(files, 30);
}

TEST(Rooms, AForbiddenIncludeIsFound) {
  const Uses uses = read_rooms();
  EXPECT_TRUE(
      forbidden_includes("phase", "#include \"slipstream/capture/frame_set.h\"", uses).empty());
  EXPECT_EQ(forbidden_includes("phase", "#include \"slipstream/geometry/lens.h\"", uses).size(),
            1U);
  EXPECT_EQ(forbidden_includes("geometry", "#include <opencv2/core.hpp>", uses).size(), 1U);
}

TEST(Rooms, DependOnNoRoomThatDependsOnThem) {
  const Uses uses = read_rooms();
  for (const auto& [room, used] : uses) {
    for (const std::string& other : used) {
      ASSERT_TRUE(uses.contains(other)) << room << " uses " << other;
      EXPECT_FALSE(uses.at(other).contains(room)) << room << " and " << other;
    }
  }
}

}  // namespace
