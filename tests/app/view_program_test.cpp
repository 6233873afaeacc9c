// Runs view and project. Drawing is skipped without OpenGL.
#include <algorithm>
#include <csignal>
#include <filesystem>

#include <gtest/gtest.h>

#include "io/file.h"
#include "tests/app/program.h"
#include "tests/base/variable.h"
#include "tests/io/grey_image.h"
#include "tests/io/temporary_folder.h"
#include "tests/view/desktop.h"

namespace slipstream::view_program_test {

class ViewProgram : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const {
    return (folder_.path() / name).string();
  }
  void simulate() const {
    const ProgramRun run = run_program({"simulate", path("scan"), "--camera", "96x72"});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }
  static void expect_refused(const std::vector<std::string>& arguments, const std::string& part) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 2) << run.err;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err << "lacks: " << part;
  }

  TemporaryFolder folder_;
};

/// Number of pixels brighter than the background.
int bright_pixels(const std::string& path) {
  const Image<std::uint16_t> grey = read_grey_image(path);
  return static_cast<int>(std::count_if(grey.begin(), grey.end(), [](int v) { return v > 90; }));
}

TEST_F(ViewProgram, DrawsScansAndCloudsWithoutAWindow) {
  simulate();
  ASSERT_EQ(run_program({"reconstruct", path("scan"), "-o", path("cloud.ply")}).exit_code, 0);
  const ProgramRun scan = run_program({"view", path("scan"), "--snapshot", path("a.png"),
                                       "--screenshot", path("b.png"), "--size", "800x600"});
  ASSERT_EQ(scan.exit_code, 0) << scan.err;
  EXPECT_EQ(read_grey_image(path("a.png")).size(), (Size{800, 600}));
  EXPECT_GT(bright_pixels(path("a.png")), 20000);
  EXPECT_GT(bright_pixels(path("b.png")), 10000);
  const ProgramRun cloud = run_program({"view", path("cloud.ply"), "--colour", "depth",
                                        "--snapshot", path("c.png"), "--size", "320x200"});
  ASSERT_EQ(cloud.exit_code, 0) << cloud.err;
  EXPECT_GT(bright_pixels(path("c.png")), 2000);
}

TEST_F(ViewProgram, DrawsTheLastCloudOfALiveScan) {
  const ProgramRun live = run_program(
      {"live", "--source", "virtual", "--camera", "96x72", "--frames", "40", "--headless", "--json",
       "--snapshot", path("a.png"), "--screenshot", path("b.png"), "--size", "640x400"});
  ASSERT_EQ(live.exit_code, 0) << live.err;
  EXPECT_NE(live.out.find(path("b.png")), std::string::npos) << live.out;
  EXPECT_GT(bright_pixels(path("a.png")), 10000);
  EXPECT_EQ(read_grey_image(path("b.png")).size(), (Size{640, 400}));
}

TEST_F(ViewProgram, RefusesBadInputInOneLine) {
  simulate();
  write_file(path("text.ply"), "no cloud");
  expect_refused({"view", path("missing.ply"), "--snapshot", path("a.png")}, "missing.ply");
  expect_refused({"view", path("text.ply"), "--snapshot", path("a.png")}, "text.ply");
  expect_refused({"view", path("text.ply"), "--steps", "4"}, "--steps applies to scans only");
  expect_refused({"view", path("scan"), "--snapshot", path("a.gif")}, ".gif");
  expect_refused({"view", path("scan"), "--snapshot", path("a.png"), "--size", "0x9"}, "--size");
  expect_refused({"view", path("scan"), "--snapshot", path("a.png"), "--colour", "pink"}, "pink");
  EXPECT_FALSE(std::filesystem::exists(path("a.png")));
}

TEST_F(ViewProgram, TakesTheLeastModulationThatItsAdviceNames) {
  const std::string dark = path("dark");
  ASSERT_EQ(
      run_program({"simulate", dark, "--camera", "96x72", "--reflectivity", "0.05"}).exit_code, 0);
  expect_refused({"view", dark, "--snapshot", path("a.png")}, "or lower --minimum-modulation");
  const ProgramRun run =
      run_program({"view", dark, "--minimum-modulation", "3", "--snapshot", path("a.png")});
  EXPECT_EQ(run.exit_code, 0) << run.err;
}

TEST_F(ViewProgram, WithoutADesktopTheWindowsSaySo) {
  simulate();
  const Variable no_display("DISPLAY", {}), no_compositor("WAYLAND_DISPLAY", {});
  const ProgramRun view = run_program({"view", path("scan")});
  EXPECT_EQ(view.exit_code, 1);
  EXPECT_NE(view.err.find("desktop"), std::string::npos) << view.err;
  EXPECT_NE(view.err.find("--snapshot or --web"), std::string::npos) << view.err;
  // Before anything is rendered, which takes this scene a minute.
  for (const std::vector<std::string>& command :
       {std::vector<std::string>{"project", "--list"},
        {"studio"},
        {"view"},
        {"live", "--source", "virtual"},
        {"capture", "--source", "virtual", "--poses", "--spacing", "15", "-o", path("poses")}}) {
    const ProgramRun run = run_program(command);
    EXPECT_EQ(run.exit_code, 1) << command.front();
    EXPECT_NE(run.err.find("desktop"), std::string::npos) << command.front() << run.err;
    EXPECT_FALSE(std::filesystem::exists(path("poses")));
  }
}

TEST_F(ViewProgram, ProjectsThreePatternsToAPictureInColour) {
  const Desktop desktop;
  expect_refused({"project", "--colour", "--strategy", "pmp", "--steps", "4"}, "a multiple of 3");
  expect_refused({"project", "--colour", "--marker"}, "and a marker");
  RunningProgram project({"project", "--colour", "--strategy", "de-bruijn"});
  EXPECT_TRUE(project.wait_for_words("showing 1 patterns")) << project.err();
  project.send(SIGINT);
  EXPECT_EQ(project.wait(), 0) << project.err();
}

TEST_F(ViewProgram, AnInterruptEndsTheProjectionAndKeepsItsLog) {
  const Desktop desktop;
  RunningProgram project({"project", "--log", path("log.csv")});
  EXPECT_TRUE(project.wait_for_words("showing")) << project.err();
  project.send(SIGINT);
  EXPECT_EQ(project.wait(), 0) << project.err();
  EXPECT_EQ(contents(path("log.csv")).substr(0, 21), "swap,pattern,seconds\n");
}

}  // namespace slipstream::view_program_test
