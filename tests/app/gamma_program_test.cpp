// Runs the program on scans from a projector with gamma.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "io/file.h"
#include "io/image_file.h"
#include "slipstream/scanner_file.h"
#include "tests/app/program.h"
#include "tests/io/grey_image.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::gamma_program_test {

class GammaProgram : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  /// Runs the program, expects success and returns stdout and stderr.
  [[nodiscard]] static std::string out_of(const std::vector<std::string>& arguments) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.out + run.err;
  }
  /// Runs the program, expects exit code 2 and returns the error, one line.
  [[nodiscard]] static std::string refusal_of(const std::vector<std::string>& arguments) {
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 2) << run.out;
    EXPECT_EQ(std::count(run.err.begin(), run.err.end(), '\n'), 1) << run.err;
    return run.err;
  }
  /// RMS error of scan/ against its ground truth, mm.
  [[nodiscard]] double rms_with(const std::string& gamma) const {
    const std::string json = out_of({"reconstruct", path("scan"), "--gamma", gamma, "--json"});
    const std::string key = "\"rms_mm\":";
    double rms = NAN;
    std::sscanf(json.c_str() + json.find(key) + key.size(), "%lf", &rms);
    return rms;
  }
  void simulate(const std::string& steps) const {
    (void)out_of({"simulate", path("scan"), "--scene", "board", "--camera", "128x96", "--world",
                  "ideal", "--virtual-gamma", "2.4", "--virtual-noise", "0.2", "--steps", steps,
                  "--low-steps", "6", "--high", "8"});
  }

 private:
  TemporaryFolder folder_;
};

bool says(const std::string& text, const std::string& words) {
  return text.find(words) != std::string::npos;
}

TEST_F(GammaProgram, CalibratesTheScannerFileThatReconstructUses) {
  simulate("6");
  (void)out_of({"calibrate", "gamma", path("scan"), "-o", path("scan/scanner.yaml"), "--map",
                path("gamma.tiff"), "--histogram", path("gamma.png")});
  const Response response =
      read_photometric_calibration(path("scan/scanner.yaml")).response.value().response;
  EXPECT_NEAR(std::get<PowerLaw>(response).gamma, 2.4, 0.005);
  EXPECT_TRUE(std::filesystem::exists(path("gamma.png")));
  EXPECT_EQ(read_map(path("gamma.tiff")).size(), (Size{128, 96}));

  (void)out_of({"simulate", path("three"), "--scene", "board", "--camera", "128x96", "--world",
                "ideal", "--virtual-gamma", "2.4", "--virtual-noise", "0.2", "--steps", "3",
                "--low-steps", "6", "--high", "8"});
  const auto depth_error = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"reconstruct", path("three"), "--json"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const std::string json = out_of(arguments);
    double rms = NAN;
    std::sscanf(json.c_str() + json.find("\"rms_mm\":") + 9, "%lf", &rms);
    return rms;
  };
  const std::vector<std::string> scanner{"--scanner", path("scan/scanner.yaml")};
  const double corrected = depth_error(scanner);
  EXPECT_LT(corrected, depth_error({}) / 10);
  EXPECT_NEAR(corrected, depth_error({"--gamma", "2.4"}), 0.02 * corrected);
}

TEST_F(GammaProgram, CorrectsBlindOrSaysWhyNot) {
  simulate("4");
  EXPECT_LT(rms_with("blind"), rms_with("none") / 3);
  simulate("3");
  // Gamma is estimated from the low frequency, which has six steps.
  EXPECT_LT(rms_with("blind"), rms_with("none") / 10);
  (void)out_of({"simulate", path("scan"), "--camera", "128x96", "--world", "ideal",
                "--virtual-gamma", "2.4", "--strategy", "pmp", "--steps", "3"});
  const std::string said = out_of({"reconstruct", path("scan"), "--gamma", "blind"});
  EXPECT_TRUE(says(said, "not corrected: three steps")) << said;
  EXPECT_TRUE(
      says(said, "warning: " + path("scan") + ": --gamma blind corrects nothing: three steps"));
}

TEST_F(GammaProgram, SaysSoWhereFramesCannotShowIt) {
  const auto run_with = [&](const std::string& command, const std::vector<std::string>& more) {
    std::vector<std::string> arguments{command, path("scan")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramRun run = run_program(arguments);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return run.out + run.err;
  };
  const auto simulated = [&](const char* gamma) {
    (void)out_of({"simulate", path("scan"), "--scene", "statue", "--camera", "160x120", "--world",
                  "ideal", "--virtual-gamma", gamma, "--strategy", "pmp", "--steps", "3"});
  };
  simulated("2.2");
  const std::string cause = "the projector's gamma (with the camera's) is not corrected";
  EXPECT_TRUE(says(run_with("reconstruct", {}), "warning: " + path("scan")));
  const std::string json = run_with("reconstruct", {"--json"});
  EXPECT_TRUE(says(json, "\"likely\": \"" + cause) && says(json, "gamma to first order")) << json;
  EXPECT_TRUE(says(run_with("check", {"--json"}), cause));
  const std::string blind = run_with("check", {"--gamma", "blind"});
  EXPECT_TRUE(says(blind, cause) && says(blind, "--gamma blind corrects nothing")) << blind;
  EXPECT_FALSE(says(blind, "try --gamma blind")) << blind;
  EXPECT_FALSE(says(run_with("reconstruct", {"--gamma", "2.2"}), "warning"));
  simulated("1");
  EXPECT_FALSE(says(run_with("reconstruct", {}), "warning"));
}

TEST_F(GammaProgram, FindsAnSCurveOrSaysWhatIsLeft) {
  const auto simulated = [&](const std::string& name, const std::string& response,
                             const std::string& steps) {
    (void)out_of({"simulate", path(name), "--scene", "board", "--camera", "128x96", "--world",
                  "ideal", "--virtual-gamma", response, "--steps", steps, "--low-steps", "6",
                  "--high", "8"});
    return path(name);
  };
  const std::string said = out_of({"calibrate", "gamma", simulated("eight", "logistic:9:0.45", "8"),
                                   "-o", path("eight/scanner.yaml")});
  EXPECT_TRUE(says(said, "response: logistic:9")) << said;
  // simulate can also read the response from a file.
  const std::string six = simulated("six", path("eight/scanner.yaml"), "6");
  const std::string refusal = refusal_of({"calibrate", "gamma", six, "-o", path("no.yaml")});
  EXPECT_TRUE(says(refusal, "rad of phase") && says(refusal, "8 steps")) << refusal;
  EXPECT_FALSE(std::filesystem::exists(path("no.yaml")));
  const std::string blind = out_of({"reconstruct", six, "--gamma", "blind"});
  EXPECT_TRUE(says(blind, "not corrected: the response matches no gamma")) << blind;
}

TEST_F(GammaProgram, MeasuresTheResponseFromUniformPatterns) {
  (void)out_of({"patterns", path("levels"), "--uniform", "18", "--projector", "64x48"});
  // Simulates camera frames of them: two thirds of the light, plus ambient light.
  for (int i = 0; i < 18; ++i) {
    char name[64];
    std::snprintf(name, sizeof name, "levels/level_%03d.png", 15 * i);
    const double light = std::pow(15 * i / 255.0, 1.8);
    write_image(path(name), Image<std::uint8_t>(
                                {40, 30}, static_cast<std::uint8_t>(std::lround(8 + 170 * light))));
  }
  const std::string said = out_of(
      {"calibrate", "gamma", "--uniform", path("levels"), "--response", "-o", path("curve.yaml")});
  EXPECT_TRUE(says(said, "gamma 1.8") || says(said, "gamma 1.79")) << said;
  const Response response =
      read_photometric_calibration(path("curve.yaml")).response.value().response;
  EXPECT_NEAR(light_at(response, 0.5), std::pow(0.5, 1.8), 0.003);

  // Half intensity requires a grey level above half.
  const std::vector<std::string> patterns{"patterns",    path("patterns"), "--strategy",
                                          "pmp",         "--steps",        "4",
                                          "--projector", "64x48",          "--precompensate"};
  auto with_curve = patterns, with_number = patterns;
  with_curve.push_back(path("curve.yaml"));
  with_number.push_back("1.8");
  (void)out_of(with_curve);
  const Image<std::uint16_t> by_curve = read_grey_image(path("patterns/pattern_00.png"));
  (void)out_of(with_number);
  const Image<std::uint16_t> by_number = read_grey_image(path("patterns/pattern_00.png"));
  EXPECT_NEAR(by_number(16, 0), 255 * std::pow(0.5, 1 / 1.8), 1);
  EXPECT_NEAR(by_curve(16, 0), by_number(16, 0), 2);
}

TEST_F(GammaProgram, UniformPatternsOf16BitsAreToldInGreyLevelsOf255) {
  make_folder(path("levels"));
  for (int i = 0; i < 18; ++i) {
    char name[64];
    std::snprintf(name, sizeof name, "levels/level_%03d.png", 15 * i);
    const double light = std::pow(15 * i / 255.0, 1.8);
    write_image(path(name),
                Image<std::uint16_t>(
                    {40, 30}, static_cast<std::uint16_t>(std::lround(257 * (8 + 170 * light)))));
  }
  const std::string said = out_of({"calibrate", "gamma", "--uniform", path("levels")});
  EXPECT_TRUE(says(said, "ambient light 8 grey levels")) << said;
}

TEST_F(GammaProgram, MatchesTheScansOfTwoCameras) {
  (void)out_of({"simulate", path("scan"), "--scene", "board", "--camera", "128x96", "--world",
                "ideal", "--virtual-gamma", "2.4", "--steps", "3", "--low-steps", "6", "--high",
                "8", "--second-camera"});
  const std::string said = out_of({"reconstruct", path("scan"), "-o", path("cloud.ply")});
  EXPECT_TRUE(says(said, "two cameras, independent of gamma")) << said;
  const double two_cameras = rms_with("none");
  (void)out_of({"reconstruct", path("scan"), "--one-camera"});
  EXPECT_TRUE(says(refusal_of({"reconstruct", path("scan"), "--match-window", "-1"}), "window"));

  std::filesystem::remove(path("scan/second/scan.yaml"));
  EXPECT_TRUE(says(refusal_of({"reconstruct", path("scan")}), "second"));
  // With one camera only, depth is wrong.
  const std::string json = out_of({"reconstruct", path("scan"), "--one-camera", "--json"});
  double one_camera = NAN;
  std::sscanf(json.c_str() + json.find("\"rms_mm\":") + 9, "%lf", &one_camera);
  EXPECT_LT(two_cameras, one_camera / 10);
}

TEST_F(GammaProgram, TakesPicturesInColourApartByTheScannerGiven) {
  (void)out_of({"simulate", path("scan"), "--scene", "board", "--camera", "128x96", "--world",
                "ideal", "--virtual-gamma", "2.2", "--colour", "--strategy", "pmp", "--steps",
                "9"});
  (void)out_of({"simulate", path("white"), "--camera", "128x96", "--world", "ideal", "--scene",
                "board", "--primaries"});
  (void)out_of({"calibrate", "colour", path("white"), "-o", path("mixture.yaml")});
  const std::string calibrate = out_of({"calibrate", "gamma", path("scan"), "--scanner",
                                        path("mixture.yaml"), "-o", path("scanner.yaml")});
  EXPECT_FALSE(says(calibrate, "without a colour mixture")) << calibrate;
  const auto measured = read_photometric_calibration(path("scanner.yaml"));
  ASSERT_TRUE(measured.response.has_value());
  EXPECT_NEAR(measured.response->gamma, 2.2, 0.05);
}

TEST_F(GammaProgram, ReproducesWithoutAnyFlag) {
  const std::string table = out_of({"reproduce", "table-4.1"});
  for (const char* words : {"table-4.1:", "published", "recomputed"}) {
    EXPECT_TRUE(says(table, words)) << words << " in " << table;
  }
}

TEST_F(GammaProgram, ReproducesTablesAndFigures) {
  const std::string json = out_of({"reproduce", "table-4.1", "figure-4.1", "--plots", path("plots"),
                                   "--report", path("plots/report.html"), "--json"});
  for (const char* words : {"\"tables\"", "\"id\": \"4.1\"", "\"published\"", "\"improved\""}) {
    EXPECT_TRUE(says(json, words)) << words << " in " << json;
  }
  EXPECT_TRUE(std::filesystem::exists(path("plots/figure-4.1.png")));
  const auto report = read_file(path("plots/report.html"));
  EXPECT_TRUE(says({report.begin(), report.end()},
                   "<img alt=\"figure-4.1\" src=\"data:image/png;base64,iVBOR"));
  EXPECT_TRUE(says(out_of({"reproduce", "--list"}), "section-4.5"));
  EXPECT_TRUE(says(refusal_of({"reproduce", "table-9.9"}), "table-9.9"));
  EXPECT_TRUE(says(refusal_of({"reproduce"}), "--list prints the names"));
}

TEST_F(GammaProgram, RefusesBadInput) {
  simulate("4");
  EXPECT_TRUE(says(refusal_of({"reconstruct", path("scan"), "--gamma", "bright"}), "bright"));
  EXPECT_TRUE(says(refusal_of({"reconstruct", path("scan"), "--gamma", "20"}), "0.5 to 11"));
  EXPECT_TRUE(says(refusal_of({"calibrate", "gamma"}), "--uniform"));
  EXPECT_TRUE(says(refusal_of({"calibrate", "gamma", path("scan"), "--response"}), "--uniform"));
  EXPECT_TRUE(says(
      refusal_of({"calibrate", "gamma", "--uniform", path("levels"), "--map", path("map.tiff")}),
      "--map"));
  (void)out_of({"simulate", path("four"), "--camera", "128x96", "--world", "ideal", "--strategy",
                "pmp", "--steps", "4"});
  EXPECT_TRUE(says(refusal_of({"calibrate", "gamma", path("four"), "--map", path("m.tiff")}), "5"));
  EXPECT_TRUE(says(refusal_of({"calibrate", "gamma", path("scan"), "-o", path("s.xml")}), ".xml"));
  EXPECT_TRUE(says(refusal_of({"calibrate", "gamma", path("nowhere")}), "nowhere"));
  EXPECT_TRUE(says(refusal_of({"calibrate", "gamma", "--uniform", path("scan")}), "level"));
  EXPECT_TRUE(says(refusal_of({"patterns", path("p"), "--uniform", "2"}), "4 to 256"));
  EXPECT_TRUE(
      says(refusal_of({"patterns", path("p"), "--precompensate", path("scan/scanner.yaml")}),
           "no gamma"));
  EXPECT_FALSE(std::filesystem::exists(path("s.xml")));
}

}  // namespace slipstream::gamma_program_test
