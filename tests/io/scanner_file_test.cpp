#include "slipstream/scanner_file.h"

#include <algorithm>
#include <fstream>
#include <string>

#include <Eigen/Geometry>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

#include "io/file.h"
#include "io/opencv_storage.h"
#include "slipstream/named_scenes.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"
#include "tests/shared_data.h"

namespace slipstream::scanner_file_test {

Scanner example() {
  Scanner scanner;
  scanner.camera.intrinsic << 900.25, 0, 320, 0, 901, 240.5, 0, 0, 1;
  scanner.camera.distortion = make_distortion(std::array{-0.1, 0.02, 1e-3, -2e-3, 0.5});
  scanner.camera.size = {640, 480};
  scanner.projector.intrinsic << 1500, 0, 512, 0, 1500, 700, 0, 0, 1;
  scanner.projector.size = {1024, 768};
  scanner.rotation << 0, -1, 0, 1, 0, 0, 0, 0, 1;
  scanner.translation = {-150.5, 20, 1.0 / 3};
  scanner.measured = "with 12 poses of the board: \"tilted\", 2026-01-31";
  return scanner;
}

TEST(ScannerFile, KeepsWhatIsNotGeometryWhenItIsReplaced) {
  const TemporaryFolder folder;
  for (const char* name : {"scanner.yaml", "scanner.xml"}) {
    const auto path = folder.path() / name;
    Scanner other = example();
    other.translation.x() = 7;
    EXPECT_TRUE(replace_geometry(path, other).empty());
    std::map<std::string, StoredMatrix> more = read_opencv_storage(path);
    more = {{"gamma", {1, 1, {2.25}}}, {"vignette", {1, 2, {0, 1}}}, {"Kc", more.at("rotation")}};
    const std::vector<std::uint8_t> text = read_file(path);
    write_file(path, with_entries({text.begin(), text.end()}, more, name));
    EXPECT_EQ(replace_geometry(path, example()), (std::vector<std::string>{"gamma", "vignette"}));
    Scanner expected = example();
    expected.photometry.response = MeasuredResponse{PowerLaw{2.25}, 2.25};
    EXPECT_EQ(read_scanner(path), expected);
    const auto entries = read_opencv_storage(path);
    EXPECT_EQ(entries.at("gamma").numbers, std::vector{2.25});
    EXPECT_FALSE(entries.contains("Kc"));
    write_file(path, std::string("no scanner"));
    EXPECT_TRUE(replace_geometry(path, example()).empty());
    EXPECT_EQ(read_scanner(path), example());
  }
}

TEST(ScannerFile, ComesBackAsItWasWritten) {
  const TemporaryFolder folder;
  for (const char* name : {"scanner.yaml", "scanner.xml"}) {
    Scanner scanner = example();
    write_scanner(folder.path() / name, scanner);
    EXPECT_EQ(read_scanner(folder.path() / name), scanner);
    scanner.photometry = {.ambient = -3.25,
                          .noise_variance = 1.0 / 7,
                          .response = MeasuredResponse{PowerLaw{2.2}, 2.2, 0.01}};
    scanner.calibrated_depths = {412.5, 1.0 / 3 + 800};
    write_scanner(folder.path() / name, scanner);
    EXPECT_EQ(read_scanner(folder.path() / name), scanner);
  }
}

TEST(ScannerFile, KeepsResidualMaps) {
  const TemporaryFolder folder;
  Scanner scanner = example();
  scanner.camera.residual = {.centre = {319.5, 239.5}, .half = {320, 240}};
  for (int i = 0; i < 6; ++i) scanner.camera.residual.terms.emplace_back(0.01 * i, -0.02);
  scanner.projector.residual = {.centre = {511.5, 383.5}, .half = {512, 384}};
  scanner.projector.residual.terms.resize(3, Eigen::Vector2d(0.5, 0.25));

  for (const char* name : {"scanner.yaml", "scanner.xml"}) {
    const auto path = folder.path() / name;
    write_scanner(path, scanner);
    EXPECT_EQ(read_scanner(path), scanner);

    // A calibration without maps takes none over.
    replace_geometry(path, example());
    EXPECT_EQ(read_scanner(path), example());
  }

  scanner.camera.residual.terms.pop_back();
  expect_error([&] { write_scanner(folder.path() / "bad.yaml", scanner); },
               {"camera_residual: invalid residual map"});
}

TEST(ScannerFile, OpensInOpenCv) {
  const TemporaryFolder folder;
  const std::string path = folder.path() / "scanner.yaml";
  write_scanner(path, example());
  const cv::FileStorage storage(path, cv::FileStorage::READ);
  cv::Mat translation;
  storage["translation"] >> translation;
  EXPECT_EQ(translation.at<double>(2), 1.0 / 3);
  EXPECT_EQ(static_cast<int>(storage["projector_width"]), 1024);
}

std::string matrix(const char* name, int rows, int columns, const std::string& numbers) {
  return std::string(name) + ": !!opencv-matrix\n   rows: " + std::to_string(rows) +
         "\n   cols: " + std::to_string(columns) + "\n   dt: d\n   data: [ " + numbers + " ]\n";
}

const std::string head = "%YAML:1.0\n---\n";
const char* const K = "900., 0., 320., 0., 901., 240., 0., 0., 1.";
const char* const identity = "1., 0., 0., 0., 1., 0., 0., 0., 1.";

TEST(ScannerFile, ReadsTheLayoutWithoutSizes) {
  const TemporaryFolder folder;
  write_file(folder.path() / "cal.yml",
             head + matrix("cam_K", 3, 3, K) + matrix("cam_kc", 1, 5, "0.1, 0., 0., 0., 0.") +
                 matrix("proj_K", 3, 3, K) + matrix("proj_kc", 1, 5, "0.2, 0., 0., 0., 0.") +
                 matrix("R", 3, 3, identity) + matrix("T", 3, 1, "100., 2., 3."));
  const Scanner scanner = read_scanner(folder.path() / "cal.yml");
  EXPECT_EQ(scanner.camera.intrinsic(1, 1), 901);
  EXPECT_EQ(scanner.projector.distortion.coefficients[0], 0.2);
  EXPECT_EQ(scanner.translation.x(), 100);
  EXPECT_EQ(scanner.camera.size, Size{});
}

TEST(ScannerFile, ReadsProjectionMatrices) {
  const Scanner known = example_scanner();
  Eigen::Matrix<double, 3, 4> pose;
  pose << known.rotation, known.translation;
  // In world coordinates other than the camera's, and scaled by arbitrary factors.
  Eigen::Isometry3d world = Eigen::Isometry3d::Identity();
  world.translate(Eigen::Vector3d(30, -20, 500));
  world.rotate(Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 2, -1).normalized()));
  Eigen::Matrix<double, 3, 4> camera = Eigen::Matrix<double, 3, 4>::Zero();
  camera.leftCols<3>() = known.camera.intrinsic;
  const auto entry = [&](const char* name, const Eigen::Matrix<double, 3, 4>& projection) {
    return matrix(name, 3, 4,
                  fmt::format("{:.17g}", fmt::join(projection.reshaped<Eigen::RowMajor>(), ", ")));
  };
  const std::string first = entry("camera_projection", -0.01 * camera * world.matrix());
  const std::string text =
      head + first +
      entry("projector_projection", 3 * known.projector.intrinsic * pose * world.matrix()) +
      "camera_width: 640\ncamera_height: 480\nambient_light: 4.\n";
  const Scanner read = scanner_from(text, "matrices.yaml");
  EXPECT_TRUE(read.camera.intrinsic.isApprox(known.camera.intrinsic, 1e-9));
  EXPECT_TRUE(read.projector.intrinsic.isApprox(known.projector.intrinsic, 1e-9));
  EXPECT_TRUE(read.rotation.isApprox(known.rotation, 1e-9));
  EXPECT_TRUE(read.translation.isApprox(known.translation, 1e-9));
  EXPECT_EQ(read.camera.size, (Size{640, 480}));
  EXPECT_EQ(read.projector.size, Size{});
  EXPECT_EQ(read.photometry.ambient, 4);

  expect_error([&] { (void)scanner_from(head + first, "a.yaml"); },
               {"a.yaml", "projector_projection", "missing"});
  expect_error(
      [&] { (void)scanner_from(head + first + matrix("projector_projection", 3, 3, K), "b.yaml"); },
      {"b.yaml", "projector_projection", "3x4"});
  const Eigen::Matrix<double, 3, 4> singular = Eigen::Matrix<double, 3, 4>::Ones();
  expect_error(
      [&] { (void)scanner_from(head + first + entry("projector_projection", singular), "c.yaml"); },
      {"c.yaml", "projector", "singular or not finite"});

  const TemporaryFolder folder;
  write_file(folder.path() / "rig.yaml", text);
  EXPECT_EQ(replace_geometry(folder.path() / "rig.yaml", known),
            std::vector<std::string>{"ambient_light"});
  EXPECT_EQ(read_scanner(folder.path() / "rig.yaml").translation, known.translation);
}

TEST(ScannerFile, ReadsTheMatricesOfTwoRealCameras) {
  const auto folder = shared_data() / "bsc-hand";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const auto entry = [&](const char* name, const char* file) {
    std::ifstream text(folder / file);
    std::vector<double> numbers(12);
    for (double& number : numbers) text >> number;
    return matrix(name, 3, 4, fmt::format("{:.17g}", fmt::join(numbers, ", ")));
  };
  const auto scanner = [&](const char* camera) {
    return scanner_from(head + "projector_width: 1280\nprojector_height: 800\n" +
                            "camera_width: 640\ncamera_height: 480\n" +
                            entry("camera_projection", camera) +
                            entry("projector_projection", "mProjector.txt"),
                        camera);
  };
  const Scanner first = scanner("mCamera1Rectified.txt"), second = scanner("mCamera2Rectified.txt");
  EXPECT_NO_THROW(require_valid(first));
  EXPECT_NO_THROW(require_valid(second));
  // The same projector, and cameras with the same viewing direction.
  EXPECT_TRUE(first.projector.intrinsic.isApprox(second.projector.intrinsic, 1e-6));
  EXPECT_TRUE(first.rotation.col(2).isApprox(second.rotation.col(2), 1e-6));
  EXPECT_GT((projector_centre(first) - projector_centre(second)).norm(), 30);
}

TEST(ScannerFile, RowsAndColumnsAreWholeNumbers) {
  std::string text = head + matrix("cam_K", 3, 3, K) + matrix("proj_K", 3, 3, K) +
                     matrix("R", 3, 3, identity) + matrix("T", 3, 1, "100., 2., 3.");
  EXPECT_NO_THROW((void)scanner_from(text, "cal.yml"));
  text.replace(text.find("rows: 3"), 7, "rows: 1.5").replace(text.find("cols: 3"), 7, "cols: 6");
  expect_error([&] { (void)scanner_from(text, "cal.yml"); }, {"cam_K", "not a matrix"});
}

TEST(ScannerFile, IsNotWrittenWhereItCouldNotBeRead) {
  const TemporaryFolder folder;
  Scanner scanner = example_scanner();
  scanner.photometry.ambient = 1e308;
  expect_error([&] { write_scanner(folder.path() / "scanner.yaml", scanner); }, {"ambient light"});
  EXPECT_EQ(entries_in(folder.path()), 0);
}

/// An SLMaster file with these entries.
std::string slmaster_file(const char* rotation, const char* size) {
  return head + matrix("M1", 3, 3, K) + matrix("D1", 1, 5, "0.1, 0., 0., 0., 0.") +
         matrix("S", 2, 1, size) + matrix("M4", 3, 3, K) +
         matrix("D4", 1, 5, "0.2, 0., 0., 0., 0.") + matrix("Rlp", 3, 3, rotation) +
         matrix("Tlp", 3, 1, "-108., 2., 3.");
}

TEST(ScannerFile, ReadsTheLayoutOfSlmaster) {
  const Scanner scanner = scanner_from(
      slmaster_file("0., -1., 0., 1., 0., 0., 0., 0., 1.", "640., 480."), "caliInfo.yml");
  EXPECT_EQ(scanner.camera.intrinsic(1, 2), 240);
  EXPECT_EQ(scanner.camera.distortion.coefficients[0], 0.1);
  EXPECT_EQ(scanner.camera.size, (Size{640, 480}));
  EXPECT_EQ(scanner.projector.distortion.coefficients[0], 0.2);
  EXPECT_EQ(scanner.projector.size, Size{});
  EXPECT_EQ(in_projector_frame(scanner, {1, 2, 500}), Eigen::Vector3d(-110, 3, 503));
}

TEST(ScannerFile, ReadsARealCalibrationOfSlmaster) {
  const auto path = shared_data() / "slmaster-mono" / "caliInfo.yml";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  const Scanner scanner = completed(read_scanner(path), path, {}, {1920, 1080});
  EXPECT_EQ(scanner.camera.size, (Size{1280, 1024}));
  EXPECT_NEAR(scanner.projector.intrinsic(0, 0), 2496.63, 0.01);
  EXPECT_NEAR(projector_centre(scanner).norm(), 109.44, 0.01);
}

TEST(ScannerFile, ReadsARealCalibration) {
  const auto path = shared_data() / "skull" / "calibration.xml";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  const Scanner scanner = read_scanner(path);
  EXPECT_EQ(scanner.camera.size, (Size{1688, 1352}));
  EXPECT_EQ(scanner.projector.size, (Size{1824, 1140}));
  EXPECT_NEAR(scanner.camera.intrinsic(0, 0), 2195.12, 0.01);
  EXPECT_NO_THROW(require_valid(scanner));
}

TEST(ScannerFile, BadOnesAreNamed) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "bad.yaml";
  const auto expect_refused = [&](const std::string& text,
                                  std::initializer_list<std::string> parts) {
    write_file(path, text);
    expect_error([&] { read_scanner(path); }, parts);
  };
  const std::string camera = matrix("camera_matrix", 3, 3, K);
  const std::string pose =
      matrix("rotation", 3, 3, identity) + matrix("translation", 3, 1, "100., 0., 0.");
  for (const char* missing : {"M4", "Rlp", "Tlp"}) {
    std::string text = slmaster_file(identity, "640., 480.");
    text.replace(text.find(missing), 1, "X");
    expect_refused(text, {"bad.yaml", missing, "missing"});
  }
  expect_refused(slmaster_file(identity, "640., 480.5"), {"bad.yaml", "S is not two numbers"});
  expect_refused(slmaster_file("1., 0., 0., 1., 0., 0.", "640., 480."), {"bad.yaml", "Rlp"});
  expect_refused("", {"bad.yaml"});
  expect_refused("not a scanner", {"bad.yaml"});
  expect_refused(head + "a: 1\n", {"bad.yaml", "camera_matrix"});
  expect_refused(head + camera + pose, {"bad.yaml", "projector_matrix", "missing"});
  expect_refused(head + camera + matrix("projector_matrix", 2, 2, "1., 0., 0., 1.") + pose,
                 {"projector_matrix", "3x3"});
  expect_refused(
      head + camera +
          matrix("projector_matrix", 3, 3, "900., 0., .Nan, 0., 901., 240., 0., 0., 1.") + pose,
      {"projector_matrix", "nan"});
  expect_refused(head + camera + "projector_matrix: text\n" + pose, {"projector_matrix"});
  expect_refused(head + "camera_width: -3\n" + camera + matrix("projector_matrix", 3, 3, K) + pose,
                 {"camera_width"});
  expect_refused(head + camera + matrix("camera_distortion", 1, 3, "1., 2., 3.") +
                     matrix("projector_matrix", 3, 3, K) + pose,
                 {"camera_distortion", "5"});
}

TEST(ScannerFile, ThatSetsAnEntryTwiceIsRefusedWithItsLine) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "scanner.yaml";
  const auto expect_refused = [&](const std::string& text,
                                  std::initializer_list<std::string> parts) {
    write_file(path, text);
    const auto name_parts = [&](const auto& action) {
      expect_error(action, {"scanner.yaml"});
      expect_error(action, parts);
    };
    name_parts([&] { (void)read_scanner(path); });
    name_parts([&] { (void)read_photometric_calibration(path); });
    name_parts([&] { (void)replace_geometry(path, example()); });
    name_parts([&] { write_photometric_calibration(path, path, {.ambient = 3}); });
    EXPECT_EQ(read_text(path), text);
  };
  const std::string good = text_of(example());
  const auto lines = std::to_string(std::count(good.begin(), good.end(), '\n') + 1);
  expect_refused(good +
                     "translation: !!opencv-matrix\n   rows: 3\n   cols: 1\n   dt: d\n"
                     "   data: [ 1, 2, 3 ]\n",
                 {"line " + lines + ": translation is set twice"});
  expect_refused(good + "---\ngamma: 2.2\n", {"second YAML document"});
  expect_refused(head + "gamma: 2\nrotation:\n   rows: 3\n   cols: 1\n   rows: 1\n",
                 {"rows is set twice"});
  const std::string xml = "<?xml version=\"1.0\"?>\n<opencv_storage>\n";
  expect_refused(xml + "<gamma>2.2</gamma>\n<!-- -->\n<gamma>1</gamma>\n</opencv_storage>\n",
                 {"line 5: gamma is set twice"});
  expect_refused(xml +
                     "<R type_id=\"opencv-matrix\">\n<rows>3</rows>\n<rows>1</rows></R>\n"
                     "</opencv_storage>\n",
                 {"line 5: rows is set twice"});
  expect_refused(xml + "</opencv_storage>\n<opencv_storage></opencv_storage>\n",
                 {"line 4: opencv_storage is set twice"});
  // The items of a list have one name.
  EXPECT_NO_THROW(
      (void)opencv_entries(xml + "<l><_>1</_><_>2</_></l></opencv_storage>", "list.xml"));
}

}  // namespace slipstream::scanner_file_test
