// Rooms of slipstream/ include only rooms that CMake lets them link.
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

namespace {
namespace fs = std::filesystem;

using Uses = std::map<std::string, std::set<std::string>>;

/// Reads one line per room: "decode: base codes frames".
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

fs::path rooms_folder() {
  return fs::path(SLIPSTREAM_SOURCE_FOLDER) / "slipstream";
}

/// The first folder below slipstream/ on the file's path.
std::string room_of(const fs::path& file) {
  return *file.lexically_relative(rooms_folder()).begin();
}

std::vector<fs::path> files_of_rooms() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(rooms_folder())) {
    if (entry.is_regular_file()) files.push_back(entry.path());
  }
  return files;
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

/// Headers that a source of `room` includes but may not; empty if none.
std::vector<std::string> forbidden_includes(const std::string& room, const std::string& source,
                                            const Uses& uses) {
  static const std::set<std::string> heavy_rooms{"calibrate", "devices", "io", "publish", "view"};
  static const std::regex slipstream_header("slipstream/([a-z_]+)/([^/]+/)?.*");
  static const std::regex no_library("(app|bench|paper|tests)/.*");
  static const std::regex heavy_library(
      "(opencv2|ceres|yaml-cpp|tiny_obj_loader|pugixml|CLI|nlohmann|GLFW|epoxy|imgui|glm|arv|boost|"
      "hidapi|zstd).*");
  std::vector<std::string> forbidden;
  for (const std::string& header : included(source)) {
    std::smatch match;
    if (std::regex_match(header, match, slipstream_header)) {
      const std::string used = match[1];
      const bool may = uses.at(room).contains(used) && !match[2].matched;
      if (used != room && !may) forbidden.push_back(header);
    } else if (std::regex_match(header, no_library)) {
      forbidden.push_back(header);
    } else if (std::regex_match(header, heavy_library) && !heavy_rooms.contains(room)) {
      forbidden.push_back(header);
    }
  }
  return forbidden;
}

/// Whether `header`, e.g. slipstream/decode/fold.h, is installed.
bool is_installed(const std::string& header) {
  static const std::regex of_a_room("slipstream/[a-z_]+/[^/]+\\.h");
  return std::regex_match(header, of_a_room) && !header.ends_with("-inl.h");
}

/// Headers of slipstream that an installed header includes but that are not installed.
std::vector<std::string> inner_includes(const std::string& header) {
  std::vector<std::string> inner;
  for (const std::string& used : included(header)) {
    if (used.starts_with("slipstream/") && !is_installed(used)) inner.push_back(used);
  }
  return inner;
}

std::string contents(const fs::path& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// Rooms that CMake leaves out of some builds.
bool may_be_off(const std::string& room) {
  static const std::set<std::string> optional{"view"};
  return optional.contains(room);
}

TEST(Rooms, IncludeOnlyWhatTheyMay) {
  const Uses uses = read_rooms();
  int files = 0;
  for (const fs::path& file : files_of_rooms()) {
    const std::string room = room_of(file);
    if (may_be_off(room) && !uses.contains(room)) continue;
    ASSERT_TRUE(uses.contains(room)) << file << " is in no room that CMake knows";
    for (const std::string& header : forbidden_includes(room, contents(file), uses)) {
      ADD_FAILURE() << file << " includes " << header << ", which " << room << " may not";
    }
    ++files;
  }
  EXPECT_GT(files, 30);
}

TEST(Rooms, AForbiddenIncludeIsFound) {
  const Uses uses = read_rooms();
  EXPECT_TRUE(
      forbidden_includes("decode", "#include \"slipstream/frames/frame_set.h\"", uses).empty());
  EXPECT_EQ(forbidden_includes("decode", "#include \"slipstream/geometry/lens.h\"", uses).size(),
            1U);
  EXPECT_EQ(forbidden_includes("geometry", "#include <opencv2/core.hpp>", uses).size(), 1U);
  EXPECT_EQ(forbidden_includes("reconstruct", "#include \"bench/timing.h\"", uses).size(), 1U);
  const std::string part = "#include \"slipstream/reconstruct/fused/fused_stages.h\"";
  EXPECT_TRUE(forbidden_includes("reconstruct", part, uses).empty());
  EXPECT_EQ(forbidden_includes("live", part, uses).size(), 1U);
}

TEST(Rooms, InstalledHeadersIncludeInstalledHeaders) {
  int headers = 0;
  for (const fs::path& file : files_of_rooms()) {
    const std::string name = file.lexically_relative(SLIPSTREAM_SOURCE_FOLDER).generic_string();
    if (!is_installed(name)) continue;
    for (const std::string& inner : inner_includes(contents(file))) {
      ADD_FAILURE() << name << " includes " << inner << ", which is not installed";
    }
    ++headers;
  }
  EXPECT_GT(headers, 30);
}

TEST(Rooms, AnInnerIncludeIsFound) {
  EXPECT_FALSE(is_installed("slipstream/decode/detail/fold.h"));
  EXPECT_FALSE(is_installed("slipstream/decode/fold-inl.h"));
  EXPECT_FALSE(is_installed("slipstream/decode/fold.cpp"));
  EXPECT_EQ(inner_includes("#include \"slipstream/decode/fold.h\"\n"
                           "#include \"slipstream/decode/detail/fold.h\"\n"
                           "#include \"slipstream/reconstruct/fused/rows.h\"\n"
                           "#include <vector>\n"),
            (std::vector<std::string>{"slipstream/decode/detail/fold.h",
                                      "slipstream/reconstruct/fused/rows.h"}));
}

/// The rooms in the table of docs/reference/architecture.md and the rooms they use, except `base`.
Uses uses_in_docs(const std::string& text) {
  static const std::regex row("\\| `([a-z]+)` \\|[^|\n]*\\| ?([a-z, ]*) ?\\|");
  static const std::regex word("[a-z]+");
  Uses uses;
  for (std::sregex_iterator match(text.begin(), text.end(), row), end; match != end; ++match) {
    const std::string used = (*match)[2];
    std::set<std::string>& rooms = uses[(*match)[1]];
    for (std::sregex_iterator name(used.begin(), used.end(), word); name != end; ++name) {
      rooms.insert(name->str());
    }
  }
  return uses;
}

TEST(Rooms, AreInTheDocsAsTheyAre) {
  const Uses documented = uses_in_docs(
      contents(fs::path(SLIPSTREAM_SOURCE_FOLDER) / "docs" / "reference" / "architecture.md"));
  for (auto [room, used] : read_rooms()) {
    if (room == "base") continue;
    used.erase("base");
    ASSERT_TRUE(documented.contains(room)) << room << " is not in docs/reference/architecture.md";
    EXPECT_EQ(documented.at(room), used) << room;
  }
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

/// Each kind of extension in docs/reference/architecture.md has a test.
TEST(Rooms, NewThingsAreTried) {
  const fs::path root = SLIPSTREAM_SOURCE_FOLDER;
  const std::string page = contents(root / "docs" / "reference" / "architecture.md");
  int tests = 0;
  for (const auto& entry : fs::directory_iterator(root / "tests" / "extensions")) {
    const std::string name = entry.path().filename();
    if (entry.path().extension() != ".cpp") continue;
    EXPECT_NE(page.find("| `" + name + "` |"), std::string::npos) << name << " is in no row";
    ++tests;
  }
  static const std::regex named("\\| `[a-z_]+_test\\.cpp` \\|");
  EXPECT_EQ(std::distance(std::sregex_iterator(page.begin(), page.end(), named), {}), tests);
}

/// Pairs of rooms where the first must not depend on the second.
TEST(Rooms, KeepTheirBorders) {
  const Uses uses = read_rooms();
  for (const auto& [room, other] : {std::pair("io", "simulate"), std::pair("calibrate", "io"),
                                    std::pair("geometry", "response"), std::pair("frames", "codes"),
                                    std::pair("decode", "response"), std::pair("live", "io")}) {
    if (uses.contains(room))
      EXPECT_FALSE(uses.at(room).contains(other)) << room << " uses " << other;
  }
}

/// Only `calibrate` and plot.cpp include OpenCV: to find boards and to draw lines and text of
/// figures.
TEST(Rooms, UseOpenCvForBoardsAndFigures) {
  for (const fs::path& file : files_of_rooms()) {
    if (room_of(file) == "calibrate" || file.filename() == "plot.cpp") continue;
    for (const std::string& header : included(contents(file))) {
      EXPECT_FALSE(header.starts_with("opencv2/")) << file << " includes " << header;
    }
  }
}

/// Kernels, compiled for every vector target, include only plain structs of slipstream.
TEST(Rooms, KernelsTakePlainArrays) {
  static const std::regex plain(
      "slipstream/(base|reconstruct/fused|cloud/(cloud|depth_rows)\\.h|decode/"
      "(motion_block|neighbourhood_vote|surface_window)"
      "\\.h|geometry/ray_table\\.h).*");
  int kernels = 0;
  for (const fs::path& file : files_of_rooms()) {
    const std::string text = contents(file);
    if (file.extension() != ".cpp" || text.find("foreach_target.h") == std::string::npos) continue;
    ++kernels;
    for (const std::string& header : included(text)) {
      if (!header.starts_with("slipstream/")) continue;
      EXPECT_TRUE(std::regex_match(header, plain)) << file << " includes " << header;
    }
  }
  EXPECT_GE(kernels, 6);
}

}  // namespace
