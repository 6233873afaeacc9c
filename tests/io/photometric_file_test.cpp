#include "slipstream/io/photometric_file.h"

#include <gtest/gtest.h>

#include "slipstream/io/file.h"
#include "slipstream/io/scanner_file.h"
#include "slipstream/simulate/named_scenes.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream {
namespace {

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
  expect_error([&] { read_photometric_calibration(file); }, {"bad.yaml", "noise_variance"});
  write_file(file, "%YAML:1.0\n---\nambient_light: 300\n");
  expect_error([&] { read_photometric_calibration(file); }, {"bad.yaml", "ambient_light", "300"});
  write_file(file, "%YAML:1.0\n---\nambient_light: dark\n");
  expect_error([&] { read_photometric_calibration(file); }, {"ambient_light"});
  write_file(file, "%YAML:1.0\n---\nambient_light: .nan\n");
  expect_error([&] { read_photometric_calibration(file); }, {"ambient_light"});
  expect_error(
      [&] {
        write_photometric_calibration(file, folder.path() / "x.xml",
                                      {.ambient = 1, .noise_variance = {}});
      },
      {"x.xml", "YAML"});
}

}  // namespace
}  // namespace slipstream
