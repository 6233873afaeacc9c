#include <cmath>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "io/file.h"
#include "io/opencv_storage.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/scanner_file.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::photometric_file_test {

TEST(PhotometricFile, StandsInAScannerFileBesideAllElse) {
  const TemporaryFolder folder;
  for (const char* const name : {"scanner.yaml", "scanner.xml"}) {
    const auto file = folder.path() / name;
    const Scanner scanner = example_scanner();
    write_scanner(file, scanner);
    EXPECT_FALSE(read_photometric_calibration(file).ambient);
    write_photometric_calibration(file, file, {.ambient = -7.25, .noise_variance = {}});
    write_photometric_calibration(file, file, {.ambient = {}, .noise_variance = 1.55});
    const PhotometricCalibration read = read_photometric_calibration(file);
    EXPECT_EQ(read.ambient, -7.25);
    EXPECT_EQ(read.noise_variance, 1.55);
    EXPECT_EQ(read_scanner(file).translation, scanner.translation);
  }
}

TEST(PhotometricFile, MayHoldNothingElse) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "new.yaml";
  write_photometric_calibration(std::nullopt, file, {.ambient = {}, .noise_variance = 2});
  EXPECT_EQ(read_photometric_calibration(file).noise_variance, 2);
  EXPECT_FALSE(read_photometric_calibration(file).ambient);
}

TEST(PhotometricFile, RefusesWhatIsOutOfRange) {
  const TemporaryFolder folder;
  const auto file = folder.path() / "bad.yaml";
  write_file(file, "%YAML:1.0\n---\nnoise_variance: 0\n");
  expect_error([&] { read_photometric_calibration(file); }, {"bad.yaml", "noise variance"});
  write_file(file, "%YAML:1.0\n---\nambient_light: 300\n");
  expect_error([&] { read_photometric_calibration(file); }, {"bad.yaml", "ambient light", "300"});
  write_file(file, "%YAML:1.0\n---\nambient_light: dark\n");
  expect_error([&] { read_photometric_calibration(file); }, {"ambient_light"});
  write_file(file, "%YAML:1.0\n---\nambient_light: .nan\n");
  expect_error([&] { read_photometric_calibration(file); }, {"ambient light"});
  expect_error(
      [&] {
        write_photometric_calibration(file, folder.path() / "x.xml",
                                      {.ambient = 1, .noise_variance = {}});
      },
      {"x.xml", "YAML"});
}

namespace fs = std::filesystem;

class PhotometricFileResponse : public testing::TestWithParam<const char*> {
 protected:
  [[nodiscard]] fs::path file(const std::string& name) const {
    return folder_.path() / (name + GetParam());
  }
  [[nodiscard]] std::string text_of(const std::string& name) const {
    const auto bytes = read_file(file(name));
    return {bytes.begin(), bytes.end()};
  }
  /// Writes the response to `to`, merged with the contents of `from`, if given.
  void write(const std::optional<std::string>& from, const std::string& to,
             const MeasuredResponse& response) const {
    write_photometric_calibration(from ? std::optional(file(*from)) : std::nullopt, file(to),
                                  {.response = response});
  }
  [[nodiscard]] std::optional<MeasuredResponse> read(const std::string& name) const {
    return read_photometric_calibration(file(name)).response;
  }

 private:
  TemporaryFolder folder_;
};

TEST_P(PhotometricFileResponse, KeepsEveryOtherEntry) {
  write_scanner(file("scanner"), example_scanner());
  EXPECT_FALSE(read("scanner"));
  write_file(file("scanner"),
             with_entries(text_of("scanner"),
                          {{"ambient_light", {1, 1, {7}}}, {"vignette", {2, 2, {1, 2, 3, 4}}}},
                          "scanner"));

  const MeasuredResponse power_law{PowerLaw{2.21}, 2.21, 0.001};
  write("scanner", "scanner", power_law);
  EXPECT_EQ(read("scanner"), power_law);
  EXPECT_EQ(read_photometric_calibration(file("scanner")).ambient, 7);
  EXPECT_EQ(read_opencv_storage(file("scanner")).at("vignette").numbers,
            (std::vector<double>{1, 2, 3, 4}));
  EXPECT_EQ(read_scanner(file("scanner")).translation, example_scanner().translation);

  // Writing it again replaces it.
  write("scanner", "copy", {PowerLaw{1.8}, 1.8, 0.002});
  EXPECT_EQ(read("copy")->gamma, 1.8);
  EXPECT_EQ(text_of("copy").find("2.21"), std::string::npos);
}

TEST_P(PhotometricFileResponse, HoldsACurve) {
  std::vector<double> values, intensities;
  for (int i = 0; i <= 16; ++i) {
    values.push_back(i / 16.0);
    intensities.push_back(10 + 100 * std::pow(i / 16.0, 1.9));
  }
  const MeasuredResponse curve{response_curve(values, intensities), 1.9, 0.01};
  write({}, "alone", curve);
  EXPECT_EQ(read("alone"), curve);
  // A later power law replaces the curve.
  const MeasuredResponse power_law{PowerLaw{2}, 2, 0.01};
  write("alone", "alone", power_law);
  EXPECT_EQ(read("alone"), power_law);
}

TEST_P(PhotometricFileResponse, IsRefusedWhereItIsNone) {
  const auto refused = [&](const std::map<std::string, StoredMatrix>& entries,
                           const std::string& words) {
    write_scanner(file("scanner"), example_scanner());
    write_file(file("bad"), with_entries(text_of("scanner"), entries, "scanner"));
    expect_error([&] { (void)read("bad"); }, {words});
    expect_error([&] { (void)read_scanner(file("bad")); }, {words});
  };
  refused({{"gamma", {1, 1, {30}}}}, "gamma 30 is out of range");
  refused({{"gamma", {1, 2, {2, 3}}}}, "gamma is not a number");
  refused({{"response_values", {1, 3, {0, 0.5, 1}}}}, "must both be present");
  refused({{"response_values", {1, 3, {0, 0.5, 1}}}, {"response_light", {1, 3, {0, 0, 0}}}},
          "does not rise");
}

INSTANTIATE_TEST_SUITE_P(Endings, PhotometricFileResponse, testing::Values(".yaml", ".xml"),
                         [](const auto& info) { return std::string(info.param).substr(1); });

}  // namespace slipstream::photometric_file_test
