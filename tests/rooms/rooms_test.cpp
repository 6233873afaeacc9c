// Rooms include only rooms that CMake lets them link.
#include <algorithm>
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

/// Reads what follows the room and `mark` in its line of the file that CMake writes: the rooms that
/// it uses in "decode: base codes frames", its public headers in "decode has maps phase_decoder".
Uses read_lines(const std::string& mark) {
  Uses uses;
  std::ifstream file(SLIPSTREAM_ROOMS_FILE);
  for (std::string line; std::getline(file, line);) {
    const std::size_t end = line.find(mark);
    if (end == std::string::npos) continue;

    const std::string room = line.substr(0, end);
    std::istringstream names(line.substr(end + mark.size()));
    uses[room] = {std::istream_iterator<std::string>(names), {}};
  }
  return uses;
}

Uses read_rooms() {
  return read_lines(":");
}

/// The room of each public header, e.g. of "maps".
std::map<std::string, std::string> rooms_of_headers() {
  std::map<std::string, std::string> rooms;
  for (const auto& [room, headers] : read_lines(" has")) {
    for (const std::string& header : headers) rooms[header] = room;
  }
  return rooms;
}

fs::path rooms_folder() {
  return fs::path(SLIPSTREAM_SOURCE_FOLDER) / "src";
}

fs::path public_folder() {
  return fs::path(SLIPSTREAM_SOURCE_FOLDER) / "include" / "slipstream";
}

/// The first folder below src/ on the file's path, or the room of a public header; empty if CMake
/// names none.
std::string room_of(const fs::path& file) {
  static const std::map<std::string, std::string> of_headers = rooms_of_headers();
  if (file.parent_path() != public_folder())
    return *file.lexically_relative(rooms_folder()).begin();

  const auto found = of_headers.find(file.stem().string());
  return found == of_headers.end() ? "" : found->second;
}

std::vector<fs::path> files_of_rooms() {
  std::vector<fs::path> files;
  for (const fs::path& folder : {rooms_folder(), public_folder()}) {
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (entry.is_regular_file()) files.push_back(entry.path());
    }
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

/// Whether a folder of headers is a room or belongs to a program.
bool is_of_project(const std::string& folder, const Uses& uses) {
  static const std::set<std::string> programs{"app", "bench", "paper", "tests"};
  return uses.contains(folder) || programs.contains(folder);
}

/// Headers that a source of `room` includes but may not; empty if none.
std::vector<std::string> forbidden_includes(const std::string& room, const std::string& source,
                                            const Uses& uses) {
  static const std::set<std::string> heavy_rooms{"calibrate", "devices", "io", "publish", "view"};
  static const std::regex inner_header("([a-z_]+)/([^/]+/)?[^/]+\\.h");
  static const std::regex heavy_library(
      "(opencv2|ceres|yaml-cpp|tiny_obj_loader|pugixml|CLI|nlohmann|GLFW|epoxy|imgui|glm|arv|boost|"
      "hidapi|zstd).*");
  std::vector<std::string> forbidden;
  for (const std::string& header : included(source)) {
    std::smatch match;
    if (header.starts_with("slipstream/")) {
      const std::string used = room_of(public_folder() / fs::path(header).filename());
      if (used != room && !uses.at(room).contains(used)) forbidden.push_back(header);
    } else if (std::regex_match(header, match, inner_header) && is_of_project(match[1], uses)) {
      const std::string used = match[1];
      const bool may = uses.contains(used) && uses.at(room).contains(used) && !match[2].matched;
      if (used != room && !may) forbidden.push_back(header);
    } else if (std::regex_match(header, heavy_library) && !heavy_rooms.contains(room)) {
      forbidden.push_back(header);
    }
  }
  return forbidden;
}

/// Headers of the project that a public header includes but that are not installed.
std::vector<std::string> inner_includes(const std::string& header, const Uses& uses) {
  std::vector<std::string> inner;
  for (const std::string& used : included(header)) {
    if (is_of_project(*fs::path(used).begin(), uses)) inner.push_back(used);
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
    if ((may_be_off(room) || room.empty()) && !uses.contains(room)) continue;
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
  EXPECT_TRUE(forbidden_includes("decode", "#include \"slipstream/frame_set.h\"", uses).empty());
  EXPECT_TRUE(forbidden_includes("decode", "#include \"frames/stepped_source.h\"", uses).empty());
  EXPECT_EQ(forbidden_includes("decode", "#include \"slipstream/scanner.h\"", uses).size(), 1U);
  EXPECT_EQ(forbidden_includes("decode", "#include \"geometry/triangulator.h\"", uses).size(), 1U);
  EXPECT_EQ(forbidden_includes("geometry", "#include <opencv2/core.hpp>", uses).size(), 1U);
  EXPECT_EQ(forbidden_includes("reconstruct", "#include \"bench/timing.h\"", uses).size(), 1U);

  const std::string part = "#include \"reconstruct/fused/fused_stages.h\"";
  EXPECT_TRUE(forbidden_includes("reconstruct", part, uses).empty());
  EXPECT_EQ(forbidden_includes("live", part, uses).size(), 1U);
}

TEST(Rooms, PublicHeadersIncludePublicHeaders) {
  const Uses uses = read_rooms();
  const std::map<std::string, std::string> rooms = rooms_of_headers();
  std::set<std::string> headers;
  for (const auto& entry : fs::directory_iterator(public_folder())) {
    const fs::path& file = entry.path();
    headers.insert(file.stem());
    EXPECT_TRUE(rooms.contains(file.stem()) || !uses.contains("view"))
        << file << " is of no room that CMake knows";
    for (const std::string& inner : inner_includes(contents(file), uses)) {
      ADD_FAILURE() << file << " includes " << inner << ", which is not installed";
    }
  }

  for (const auto& [header, room] : rooms) {
    EXPECT_TRUE(headers.contains(header)) << room << " has no " << header << ".h";
  }
}

/// What stands for programs outside includes public headers alone; one extension adds a flag to the
/// program, by its header.
TEST(Rooms, ProgramsOutsideIncludePublicHeaders) {
  const Uses uses = read_rooms();
  const fs::path root = SLIPSTREAM_SOURCE_FOLDER;
  int files = 0;
  for (const char* const folder : {"examples", "ros/src", "tests/extensions", "tests/install"}) {
    for (const auto& entry : fs::recursive_directory_iterator(root / folder)) {
      if (entry.path().extension() != ".cpp") continue;
      ++files;
      for (const std::string& inner : inner_includes(contents(entry.path()), uses)) {
        if (inner == "app/commands.h" || inner.starts_with("tests/")) continue;
        ADD_FAILURE() << entry.path() << " includes " << inner << ", which is not installed";
      }
    }
  }
  EXPECT_GT(files, 10);
}

TEST(Rooms, AnInnerIncludeIsFound) {
  EXPECT_EQ(inner_includes("#include \"slipstream/maps.h\"\n"
                           "#include \"decode/fold.h\"\n"
                           "#include \"reconstruct/fused/rows.h\"\n"
                           "#include <Eigen/Core>\n"
                           "#include <vector>\n",
                           read_rooms()),
            (std::vector<std::string>{"decode/fold.h", "reconstruct/fused/rows.h"}));
}

/// The rooms in the table of docs/reference/architecture.md and the rooms they use, except `base`.
Uses uses_in_docs(const std::string& text) {
  static const std::regex row("\\| `([a-z_]+)` \\|[^|\n]*\\| ?([a-z_, ]*) ?\\|");
  static const std::regex word("[a-z_]+");
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

/// Sources without a header of their name, and why.
const std::map<std::string, std::string> sources_without_own_header{
    {"src/calibrate/verification",
     "verify_scanner is in geometry_calibration.h, whose own source is long"},
    {"src/cloud/spheres", "find_spheres is in measure.h, whose own source is long"},
    {"app/main", "nothing else calls it"},
    {"python/bindings/module", "defines the Python module, which only Python loads"}};

/// Headers that declare the commands, parts of the module, sinks, methods or the screen of sources
/// without a header.
const std::map<std::string, std::string> headers_of_many{
    {"app", "app/commands.h"},
    {"python/bindings", "python/bindings/bindings.h"},
    {"src/publish", "publish/sink_kind.h"},
    {"src/spatial", "spatial/methods.h"},
    {"src/view", "view/cloud_screen.h"}};

/// Whether the source has a header of its name beside it or, for one of a room such as
/// src/decode/maps.cpp, a public one; or else includes the one of many sources.
bool has_own_header(const fs::path& source) {
  fs::path beside = source;
  if (fs::exists(beside.replace_extension(".h"))) return true;

  const fs::path public_header = public_folder() / beside.filename();
  if (fs::exists(public_header) && room_of(public_header) == room_of(source)) return true;

  const fs::path folder = source.parent_path().lexically_relative(SLIPSTREAM_SOURCE_FOLDER);
  const auto shared = headers_of_many.find(folder);
  return shared != headers_of_many.end() &&
         std::ranges::count(included(contents(source)), shared->second) > 0;
}

/// Sources of the rooms that are built, of the program, of the Python module and of `reproduce`.
std::vector<fs::path> sources_with_headers() {
  const Uses uses = read_rooms();
  std::vector<fs::path> files;
  for (const fs::path& file : files_of_rooms()) {
    if (uses.contains(room_of(file))) files.push_back(file);
  }

  for (const char* const folder : {"app", "paper", "python/bindings"}) {
    for (const auto& entry : fs::directory_iterator(fs::path(SLIPSTREAM_SOURCE_FOLDER) / folder)) {
      files.push_back(entry.path());
    }
  }

  std::erase_if(files, [](const fs::path& file) { return file.extension() != ".cpp"; });
  return files;
}

/// The name of a source leads to its declarations.
TEST(Rooms, SourcesHaveAHeaderOfTheirName) {
  const std::vector<fs::path> sources = sources_with_headers();
  for (const fs::path& file : sources) {
    fs::path name = file.lexically_relative(SLIPSTREAM_SOURCE_FOLDER);
    name.replace_extension();
    if (sources_without_own_header.contains(name.string())) continue;
    EXPECT_TRUE(has_own_header(file)) << file;
  }

  EXPECT_GT(sources.size(), 150U);
  for (const auto& [name, reason] : sources_without_own_header) {
    EXPECT_TRUE(fs::exists(fs::path(SLIPSTREAM_SOURCE_FOLDER) / (name + ".cpp"))) << name;
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
      "(base|reconstruct/fused)/.*|slipstream/(cloud|error|image)\\.h|cloud/depth_rows\\.h|"
      "decode/(motion_block|neighbourhood_vote|surface_window)\\.h|geometry/ray_table\\.h|"
      "simulate/(frame_rows|lens_packet|packets-inl|ray_packet|surface_packet|triangle_tree)\\.h");
  const Uses uses = read_rooms();
  int kernels = 0;
  for (const fs::path& file : files_of_rooms()) {
    const std::string text = contents(file);
    if (file.extension() != ".cpp" || text.find("foreach_target.h") == std::string::npos) continue;
    ++kernels;
    for (const std::string& header : included(text)) {
      if (!is_of_project(*fs::path(header).begin(), uses) && !header.starts_with("slipstream/")) {
        continue;
      }
      EXPECT_TRUE(std::regex_match(header, plain)) << file << " includes " << header;
    }
  }
  EXPECT_GE(kernels, 6);
}

}  // namespace
