// Calibrations that scripts save: .npz files, and folders of text files with a matrix each.
#include "io/matrix_files.h"

#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/numbers.h"
#include "io/file.h"
#include "io/npz_file.h"
#include "slipstream/named_scenes.h"
#include "slipstream/scanner_file.h"
#include "tests/io/expect_error.h"
#include "tests/io/numpy_files.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::matrix_files_test {
namespace fs = std::filesystem;

using Matrices = std::map<std::string, Eigen::MatrixXd>;

std::string npz_of(const Matrices& matrices, bool deflated = false) {
  std::vector<std::pair<std::string, std::string>> files;
  for (const auto& [name, matrix] : matrices) files.emplace_back(name + ".npy", npy_of(matrix));
  return zip_of(files, deflated);
}

Scanner known() {
  Scanner scanner = example_scanner();
  scanner.camera.distortion = make_distortion(std::array{-0.1, 0.02, 1e-3, -2e-3, 0.01});
  scanner.projector.distortion = make_distortion(std::array{0.05, -0.01, 2e-3, 1e-3, 0.0});
  return scanner;
}

Eigen::MatrixXd distortion_of(const Lens& lens) {
  return Eigen::RowVectorXd::Map(lens.distortion.coefficients.data(), 5);
}

/// The matrices of the known scanner by names of the camera's and projector's, R and T.
Matrices named(const std::vector<std::string>& names) {
  const Scanner scanner = known();
  return {{names[0], scanner.camera.intrinsic},
          {names[1], distortion_of(scanner.camera)},
          {names[2], scanner.projector.intrinsic},
          {names[3], distortion_of(scanner.projector)},
          {names[4], scanner.rotation},
          {names[5], scanner.translation}};
}

void expect_known(const Scanner& read) {
  const Scanner truth = known();
  EXPECT_EQ(read.camera.intrinsic, truth.camera.intrinsic);
  EXPECT_EQ(read.camera.distortion, truth.camera.distortion);
  EXPECT_EQ(read.projector.intrinsic, truth.projector.intrinsic);
  EXPECT_EQ(read.projector.distortion, truth.projector.distortion);
  EXPECT_EQ(read.rotation, truth.rotation);
  EXPECT_EQ(read.translation, truth.translation);
}

class MatrixFilesNamed : public testing::TestWithParam<std::vector<std::string>> {
 protected:
  TemporaryFolder folder_;
};

TEST_P(MatrixFilesNamed, AreReadFromNpz) {
  for (const bool deflated : {false, true}) {
    const fs::path path = folder_.path() / "scanner.npz";
    write_file(path, npz_of(named(GetParam()), deflated));
    expect_known(read_scanner(path));
  }
}

TEST_P(MatrixFilesNamed, AreReadFromTextFiles) {
  for (const auto& [name, matrix] : named(GetParam())) {
    std::string text = "# " + name + "\n";
    for (Eigen::Index row = 0; row < matrix.rows(); ++row) {
      for (Eigen::Index column = 0; column < matrix.cols(); ++column) {
        text += fmt::format("{}{}", column == 0 ? "" : " ", matrix(row, column));
      }
      text += '\n';
    }
    write_file(folder_.path() / (name + ".txt"), text);
  }
  write_file(folder_.path() / "notes.txt", std::string("calibrated on Monday\n"));
  expect_known(read_scanner(folder_.path()));
}

INSTANTIATE_TEST_SUITE_P(
    Names, MatrixFilesNamed,
    testing::Values(std::vector<std::string>{"cameraMatrix1", "distCoeffs1", "cameraMatrix2",
                                             "distCoeffs2", "R", "T"},
                    std::vector<std::string>{"K1", "D1", "K2", "D2", "R", "T"},
                    std::vector<std::string>{"K1", "dist1", "K2", "dist2", "R", "t"},
                    std::vector<std::string>{"K_cam", "dist_cam", "K_proj", "dist_proj", "R", "T"},
                    std::vector<std::string>{"camera_matrix", "dist", "projector_matrix",
                                             "projector_dist", "R", "T"},
                    std::vector<std::string>{"mtx", "camDist", "projMtx", "projDist", "rot",
                                             "trans"}));

TEST(MatrixFiles, MayBeStoredByColumns) {
  const Eigen::MatrixXd matrix = known().rotation;
  const StoredEntries entries =
      npz_arrays(bytes_of(zip_of({{"R.npy", npy_of(matrix, true)}}, false)));
  const StoredMatrix& read = entries.at("R");
  ASSERT_EQ(read.numbers.size(), 9U);
  EXPECT_EQ(read.numbers[1], matrix(0, 1));
}

TEST(MatrixFiles, RefuseMoreThan64MiBOr4096Arrays) {
  const std::string large(std::size_t{40} << 20, '\0');
  const std::string zip = zip_of({{"a.npy", large}, {"b.npy", large}}, false);
  expect_error([&] { (void)arrays_of_npz(bytes_of(zip), std::uint64_t{1} << 26); }, {"64 MiB"});

  // Those above the limit of one array do not count.
  EXPECT_EQ(arrays_of_npz(bytes_of(zip), 1000).size(), 2U);

  const std::string many =
      zip_of(std::vector(4097, std::pair{std::string("a.npy"), std::string()}), false);
  expect_error([&] { (void)arrays_of_npz(bytes_of(many), 1000); }, {"4097 arrays", "4096"});
}

TEST(MatrixFiles, NameWhatIsThereIfOneIsMissing) {
  const TemporaryFolder folder;
  Matrices matrices = named({"K_cam", "dist_cam", "A", "dist_proj", "R", "T"});
  const fs::path path = folder.path() / "scanner.npz";
  write_file(path, npz_of(matrices));
  expect_error([&] { (void)read_scanner(path); },
               {"scanner.npz", "no projector_matrix", "A, K_cam, R, T", "dist_proj"});

  matrices["camera_K"] = matrices["K_cam"];
  write_file(path, npz_of(matrices));
  expect_error([&] { (void)read_scanner(path); }, {"both camera_matrix"});
}

TEST(MatrixFiles, RefuseEveryDamage) {
  const TemporaryFolder folder;
  const fs::path path = folder.path() / "scanner.npz";
  const std::string whole = npz_of(named({"K_cam", "dist_cam", "K_proj", "dist_proj", "R", "T"}));
  for (std::size_t size = 0; size < whole.size(); size += 7) {
    write_file(path, whole.substr(0, size));
    EXPECT_THROW((void)read_scanner(path), Error) << size;
  }

  expect_error([&] { (void)read_scanner(folder.path()); }, {"without text files"});
}

}  // namespace slipstream::matrix_files_test
