// Runs `slipstream verify`.
#include <filesystem>

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "slipstream/named_scenes.h"
#include "tests/app/program.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::verify_program_test {

class VerifyProgram : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  void simulate(const std::string& scan, const std::string& scene, const std::string& seed) {
    const ProgramRun run = run_program(
        {"simulate", path(scan), "--scene", scene, "--camera", "320x240", "--seed", seed});
    ASSERT_EQ(run.exit_code, 0) << run.err;
  }

  [[nodiscard]] nlohmann::json verified(const std::string& artefacts) const {
    write_file(path("artefacts.yaml"), artefacts);
    const ProgramRun run =
        run_program({"verify", path("artefacts.yaml"), "-o", path("report"), "--json"});
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.exit_code == 0 ? nlohmann::json::parse(run.out) : nlohmann::json();
  }

  void expect_refused(const std::vector<std::string>& arguments, const std::string& part) const {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 2);
    EXPECT_EQ(run.out, "");
    EXPECT_NE(run.err.find(part), std::string::npos) << run.err;
    EXPECT_FALSE(std::filesystem::exists(path("report")));
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(VerifyProgram, MeasuresScansAgainstCertifiedValues) {
  simulate("ball", "sphere", "1");
  simulate("one", "board", "2");
  simulate("two", "board", "3");
  const double diameter = 0.8 * working_volume(example_scanner({320, 240})).extent;
  const auto certified = [&](double off) {
    return fmt::format(
        "diameters: {}\nspheres: ball\nplanes: [one, two]\nrepeated: [one, two]\ndiagonal: 400\n",
        diameter + off);
  };
  const nlohmann::json right = verified(certified(0)), off = verified(certified(0.1));
  EXPECT_NEAR(right["figures_mm"]["probing_size"].get<double>(), 0, 0.3);
  EXPECT_NEAR(off["spheres"][0]["size_mm"].get<double>(),
              right["spheres"][0]["size_mm"].get<double>() - 0.1, 1e-9);
  EXPECT_EQ(right["planes"].size(), 2U);
  EXPECT_GT(right["figures_mm"]["precision"].get<double>(), 0.01);
  EXPECT_EQ(right["diagonal_mm"], 400);
  EXPECT_NE(right["verdict"].get<std::string>().find("systematic errors"), std::string::npos);
  const std::string report = contents(path("report/report.html"));
  for (const char* part : {"<td>slipstream verify ", "CRC-32", "dual-frequency", "camera 320x240",
                           "root of the sum of squares"}) {
    EXPECT_NE(report.find(part), std::string::npos) << part;
  }
  EXPECT_TRUE(report.find("<h1>Accuracy of a 3-D scanner") != std::string::npos);
}

TEST_F(VerifyProgram, EndsWithExitCode2IfALimitIsExceeded) {
  simulate("one", "board", "2");
  write_file(path("artefacts.yaml"), "planes: one\n");
  const auto exit_code = [&](const std::string& limit) {
    return run_program({"verify", path("artefacts.yaml"), "--limits", "flatness=" + limit, "-o",
                        path("report")})
        .exit_code;
  };
  EXPECT_EQ(exit_code("50"), 0);
  EXPECT_EQ(exit_code("0.001"), 2);
  EXPECT_NE(contents(path("report/report.html")).find("<td>fail</td>"), std::string::npos);
}

TEST_F(VerifyProgram, RefusesWhatItCannotVerify) {
  simulate("one", "board", "2");
  write_file(path("ball.yaml"), "diameters: 40\nspheres: one\n");
  write_file(path("copies.yaml"), "repeated: [one, one]\n");
  const std::string report = path("report");
  expect_refused({"verify", "-o", report}, "--rehearse");
  expect_refused({"verify", path("ball.yaml"), "--rehearse", "-o", report},
                 "--rehearse uses virtual artefacts");
  expect_refused({"verify", path("copies.yaml"), "--limits", "flat=1", "-o", report},
                 "--limits flat=1: expected KEY=MM");
  expect_refused({"verify", path("copies.yaml"), "--limits", "flatness=-1", "-o", report},
                 "expected a length above 0 mm");
  expect_refused({"verify", path("none.yaml"), "-o", report}, "none.yaml");
  expect_refused({"verify", path("ball.yaml"), "-o", report}, "no sphere of diameter 40 mm");
  expect_refused({"verify", path("copies.yaml"), "-o", report}, "copies");
}

}  // namespace slipstream::verify_program_test
