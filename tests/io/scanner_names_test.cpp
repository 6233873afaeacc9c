// Calibrations of other tools, read as scanner files.
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gtest/gtest.h>

#include "io/file.h"
#include "io/opencv_storage.h"
#include "io/result_files.h"
#include "io/scan_folder.h"
#include "slipstream/named_scenes.h"
#include "slipstream/scan_files.h"
#include "slipstream/scanner_file.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"
#include "tests/shared_data.h"

namespace slipstream::scanner_names_test {
namespace fs = std::filesystem;
using Entries = std::map<std::string, StoredMatrix>;

StoredMatrix stored(const Eigen::MatrixXd& matrix) {
  StoredMatrix entry{static_cast<int>(matrix.rows()), static_cast<int>(matrix.cols())};
  for (const auto& row : matrix.rowwise()) {
    entry.numbers.insert(entry.numbers.end(), row.begin(), row.end());
  }
  return entry;
}

StoredMatrix number(double value) {
  return {1, 1, {value}};
}

/// The first `count` coefficients, as a column.
StoredMatrix distortion(const Lens& lens, int count) {
  return stored(Eigen::VectorXd::Map(lens.distortion.coefficients.data(), count));
}

/// A scanner with different numbers everywhere and distortion of four coefficients.
Scanner known(int variant = 0) {
  Scanner scanner = example_scanner();
  scanner.photometry = {};
  scanner.camera.size = {640, 480 + variant};
  scanner.projector.size = {1280, 800 + variant};
  scanner.camera.intrinsic(0, 0) += 17 + variant;
  scanner.translation.z() += variant;
  scanner.camera.distortion = make_distortion(std::array{-0.1, 0.02, 1e-3, -2e-3});
  scanner.projector.distortion = make_distortion(std::array{0.05, -0.01, 2e-3, 1e-3});
  return scanner;
}

void expect_known(const Scanner& read, const Scanner& truth) {
  for (const auto lens : {&Scanner::camera, &Scanner::projector}) {
    EXPECT_TRUE((read.*lens).intrinsic.isApprox((truth.*lens).intrinsic, 1e-12));
    EXPECT_EQ((read.*lens).distortion, (truth.*lens).distortion);
  }
  EXPECT_TRUE(read.rotation.isApprox(truth.rotation, 1e-9));
  EXPECT_TRUE(read.translation.isApprox(truth.translation, 1e-9)) << read.translation.transpose();
}

/// Two matrices, two distortions, a rotation and a translation, by name.
Entries geometry(const Scanner& scanner, const std::array<const char*, 6>& names) {
  return {{names[0], stored(scanner.camera.intrinsic)},
          {names[1], distortion(scanner.camera, 4)},
          {names[2], stored(scanner.projector.intrinsic)},
          {names[3], distortion(scanner.projector, 4)},
          {names[4], stored(scanner.rotation)},
          {names[5], stored(scanner.translation)}};
}

constexpr std::array<std::array<const char*, 6>, 4> one_file_names{{
    {"cameraMatrix1", "distCoeffs1", "cameraMatrix2", "distCoeffs2", "R", "T"},
    {"M1", "D1", "M2", "D2", "R", "T"},
    {"cam_int", "cam_dist", "proj_int", "proj_dist", "roration", "translation"},
    {"camK", "camKc", "prjK", "prjKc", "R", "T"},
}};

TEST(ScannerNames, OfOneFileAreRead) {
  for (int variant = 0; variant < 3; ++variant) {
    const Scanner truth = known(variant);
    for (const auto& names : one_file_names) {
      SCOPED_TRACE(names[0]);
      Entries entries = geometry(truth, names);
      entries["rms"] = number(0.2);
      const Scanner read = scanner_from(new_storage(entries, variant == 1), "calibration");
      expect_known(read, truth);
      EXPECT_EQ(read.camera.size, Size{});
      EXPECT_EQ(read.projector.size, Size{});
    }
  }
}

/// As the export from MATLAB in docs/reference/files.md writes them.
TEST(ScannerNames, OfPlainYamlAreRead) {
  std::string text = "%YAML:1.0\n---\n";
  for (const auto& [name, entry] : geometry(known(), one_file_names[0])) {
    text += fmt::format("{}: {{rows: {}, cols: {}, data: [{:.17g}, ]}}\n", name, entry.rows,
                        entry.columns, fmt::join(entry.numbers, ", "));
  }
  expect_known(scanner_from(text, "scanner.yaml"), known());
}

TEST(ScannerNames, TellWhatAnIncompleteFileLacks) {
  for (const auto& names : one_file_names) {
    for (const int part : {0, 2, 4, 5}) {
      Entries entries = geometry(known(), names);
      entries.erase(names[part]);
      expect_error([&] { (void)scanner_from(new_storage(entries, true), "cal.xml"); },
                   {std::string("cal.xml: ") + names[part] + " is missing"});
    }
  }
  expect_error(
      [] {
        (void)scanner_from(new_storage({{"rms", number(1)}}, false), "cal.yml");
      },
      {"cal.yml: no camera matrix", "cameraMatrix1", "cam_int", "intrinsic_mat"});
}

TEST(ScannerNames, PictureSizesOfOtherToolsAreRead) {
  Entries kamino = geometry(known(), one_file_names[2]);
  kamino["img_shape"] = {2, 1, {480, 640}};  // height first
  EXPECT_EQ(scanner_from(new_storage(kamino, true), "k").camera.size, (Size{640, 480}));

  const TemporaryFolder folder;
  const fs::path calibration = folder.path() / "calibration.yml";
  write_file(calibration, new_storage(geometry(known(), one_file_names[3]), false));
  write_file(folder.path() / "calib-info.yml",
             std::string("%YAML:1.0\ncamW: 640\ncamH: 480\nprjW: 1280\nprjH: 800\n"
                         "boardSize: [7, 10]\n"));
  const Scanner read = read_scanner(scanner_in(folder.path(), "calibration.yml,calib-info.yml"));
  expect_known(read, known());
  EXPECT_EQ(read.camera.size, (Size{640, 480}));
  EXPECT_EQ(read.projector.size, (Size{1280, 800}));
}

/// Writes a camera's and a projector's file; returns both names.
fs::path write_pair(const TemporaryFolder& folder, const Entries& camera, const Entries& projector,
                    const std::string& ending) {
  write_file(folder.path() / ("camera" + ending), new_storage(camera, ending == ".xml"));
  write_file(folder.path() / ("projector" + ending), new_storage(projector, ending == ".xml"));
  return scanner_in(folder.path(), "camera" + ending + ",projector" + ending);
}

/// A device's file of sl_sensor.
Entries device_of_sl_sensor(const Lens& lens) {
  return {{"intrinsic_mat", stored(lens.intrinsic)},
          {"lens_distortion", distortion(lens, 5)},
          {"resolution_x", number(lens.size.width)},
          {"resolution_y", number(lens.size.height)}};
}

Entries camera_of_sl_sensor(const Scanner& scanner) {
  Entries camera = device_of_sl_sensor(scanner.camera);
  camera["extrinsic_rot"] = stored(scanner.rotation);
  camera["extrinsic_trans"] = stored(scanner.translation);
  return camera;
}

TEST(ScannerNames, OfTwoFilesAreRead) {
  for (int variant = 0; variant < 3; ++variant) {
    const TemporaryFolder folder;
    const Scanner truth = known(variant);
    const fs::path path = write_pair(folder, camera_of_sl_sensor(truth),
                                     device_of_sl_sensor(truth.projector), ".xml");
    const Scanner read = read_scanner(path);
    expect_known(read, truth);
    EXPECT_EQ(read.camera.size, truth.camera.size);
    EXPECT_EQ(read.projector.size, truth.projector.size);

    const Entries all = geometry(truth, one_file_names[1]);
    const auto only = [&](std::initializer_list<const char*> names) {
      Entries some;
      for (const char* name : names) some[name] = all.at(name);
      return some;
    };
    expect_known(
        read_scanner(write_pair(folder, only({"M1", "D1", "M2", "D2"}), only({"R", "T"}), ".yml")),
        truth);
  }
}

TEST(ScannerNames, TellWhatTwoFilesLack) {
  const TemporaryFolder folder;
  const Scanner truth = known();
  const Entries camera = camera_of_sl_sensor(truth);
  const Entries projector = device_of_sl_sensor(truth.projector);
  const fs::path both = write_pair(folder, camera, projector, ".xml");
  const fs::path first = folder.path() / "camera.xml", second = folder.path() / "projector.xml";
  const auto pair_of = [](const fs::path& one, const fs::path& other) {
    return fs::path(one.string() + "," + other.string());
  };
  expect_error([&] { (void)read_scanner(first); },
               {"camera.xml: the projector's intrinsic_mat is missing", "name its file too"});
  expect_error([&] { (void)read_scanner(pair_of(second, first)); },
               {"extrinsic_rot is missing in the first file", "camera's file first"});
  expect_error([&] { (void)read_scanner(pair_of(first, folder.path() / "other.xml")); },
               {"other.xml"});
  Entries less = projector;
  less.erase("intrinsic_mat");
  write_file(second, new_storage(less, true));
  expect_error([&] { (void)read_scanner(both); },
               {"camera.xml,", "projector.xml: the projector's intrinsic_mat is missing"});
  try {
    (void)read_scanner(both);
  } catch (const Error& error) {
    EXPECT_TRUE(std::string(error.what()).ends_with("missing")) << "both files were named";
  }

  write_scanner(second, truth);
  expect_error([&] { (void)read_scanner(pair_of(second, second)); }, {"complete", "name it alone"});
}

/// The camera_info files of both devices as ROS's calibration of a stereo pair writes them, with
/// the projector along `axis` of the rectified frame.
std::array<Entries, 2> camera_infos(const Scanner& scanner, int axis) {
  const Eigen::Vector3d centre = projector_centre(scanner);
  Eigen::Matrix3d rectify;
  rectify.row(axis) = centre.normalized();
  rectify.row(1 - axis) = centre.cross(Eigen::Vector3d::UnitZ()).normalized();
  rectify.row(2) = rectify.row(0).cross(rectify.row(1));
  Eigen::Matrix<double, 3, 4> projection = Eigen::Matrix<double, 3, 4>::Zero();
  projection.leftCols<3>() << 700, 0, 300, 0, 650, 250, 0, 0, 1;
  std::array<Entries, 2> files;
  for (Entries& file : files) {
    const bool is_camera = &file == &files[0];
    const Lens& lens = is_camera ? scanner.camera : scanner.projector;
    if (!is_camera) {  // metres
      const Eigen::Vector3d t = -centre.norm() / 1000 * Eigen::Vector3d::Unit(axis);
      projection.col(3) = projection.leftCols<3>() * t;
      rectify = rectify * scanner.rotation.transpose();
    }
    file = {{"image_width", number(lens.size.width)},
            {"image_height", number(lens.size.height)},
            {"camera_name", {.text = is_camera ? "left" : "right"}},
            {"camera_matrix", stored(lens.intrinsic)},
            {"distortion_model", {.text = "plumb_bob"}},
            {"distortion_coefficients", distortion(lens, 5)},
            {"rectification_matrix", stored(rectify)},
            {"projection_matrix", stored(projection)}};
  }
  return files;
}

TEST(ScannerNames, OfCameraInfoGiveThePoseByItsRectificationInMetres) {
  for (int variant = 0; variant < 3; ++variant) {
    for (const int axis : {0, 1}) {
      const TemporaryFolder folder;
      const Scanner truth = known(variant);
      const auto [camera, projector] = camera_infos(truth, axis);
      const Scanner read = read_scanner(write_pair(folder, camera, projector, ".yaml"));
      expect_known(read, truth);
      EXPECT_EQ(read.camera.size, truth.camera.size);
      EXPECT_EQ(read.projector.size, truth.projector.size);
    }
  }
}

TEST(ScannerNames, OfCameraInfoThatGiveNoPoseAreRefused) {
  const TemporaryFolder folder;
  const auto expect_refused = [&](const auto& change, std::initializer_list<std::string> parts) {
    auto [camera, projector] = camera_infos(known(), 0);
    change(camera, projector);
    const fs::path path = write_pair(folder, camera, projector, ".yaml");
    expect_error([&] { (void)read_scanner(path); }, parts);
  };
  expect_refused([](Entries& camera, Entries&) { camera["distortion_model"].text = "equidistant"; },
                 {"distortion_model is equidistant", "plumb_bob"});
  expect_refused([](Entries&, Entries& projector) { projector.erase("rectification_matrix"); },
                 {"the projector's rectification_matrix is missing"});
  expect_refused(
      [](Entries& camera, Entries& projector) {
        projector["projection_matrix"] = camera["projection_matrix"];
      },
      {"no baseline", "stereo pair"});
  expect_error([&] { (void)read_scanner(folder.path() / "camera.yaml"); },
               {"camera.yaml: the projector's camera_matrix is missing", "name its file too"});
}

TEST(ScannerNames, OfTwoFilesHoldWhereverAScannerFileDoes) {
  const TemporaryFolder folder;
  const Scanner truth = known();
  const fs::path path =
      write_pair(folder, camera_of_sl_sensor(truth), device_of_sl_sensor(truth.projector), ".xml");
  // Adding to them writes one file in slipstream's names.
  const fs::path added = folder.path() / "scanner.yaml";
  write_photometric_calibration(path, added, {.ambient = 3});
  expect_known(read_scanner(added), truth);
  EXPECT_EQ(read_scanner(added).photometry.ambient, 3);

  DistinctFiles distinct;
  distinct.add_scanner(path);
  for (const char* name : {"camera.xml", "projector.xml"}) {
    expect_error([&] { distinct.add_scanner_output(folder.path() / name); },
                 {name, "would be overwritten"});
  }

  const ScanFiles scan = scan_files_from(
      "slipstream: 1\nstrategy: {name: pmp, steps: 4}\n"
      "scanner: camera.xml,projector.xml\ncolour_scanner: camera.xml,projector.xml\n",
      "scan.yaml", folder.path());
  expect_known(read_scanner(*scan.scanner), truth);
  EXPECT_EQ(scan.colour_scanner, scan.scanner);
  const std::uint32_t before = checksum_of(scan);
  write_file(folder.path() / "projector.xml", std::string("other"));
  const std::uint32_t after = checksum_of(scan);
  EXPECT_NE(after, before);

  // The scanner of another colour camera counts as much.
  ScanFiles of_colour = scan;
  of_colour.scanner.reset();
  const std::uint32_t of_other = checksum_of(of_colour);
  write_file(folder.path() / "projector.xml", std::string("another"));
  EXPECT_NE(checksum_of(of_colour), of_other);
  write_file(folder.path() / "projector.xml", std::string("other"));

  // The white picture of a colour scan counts too.
  ScanFiles in_colour = scan;
  in_colour.white = folder.path() / "white.png";
  write_file(*in_colour.white, std::string("white"));
  EXPECT_NE(checksum_of(in_colour), after);

  // A comma in the name of an existing file.
  write_scanner(folder.path() / "a,b.yaml", truth);
  EXPECT_EQ(read_scanner(scanner_in(folder.path(), "a,b.yaml")), truth);
}

TEST(ScannerNames, OfRealFilesAreRead) {
  const fs::path folder = shared_cases() / "12-scanner-names";
  if (!fs::exists(folder)) GTEST_SKIP() << folder << " is not there";
  const auto read = [&](const fs::path& name) {
    return completed(read_scanner(scanner_in(folder, name)), name, {}, {1920, 1080});
  };
  const Scanner kamino = read("kamino.xml");
  EXPECT_EQ(kamino.camera.size, (Size{1280, 1024}));
  EXPECT_NEAR(projector_centre(kamino).norm(), 644.20, 0.01);
  // Cut off before the numbers of T.
  expect_error([&] { (void)read("bingyao.yml"); }, {"bingyao.yml: T is not a matrix of numbers"});
  const Scanner sensor = read_scanner(scanner_in(folder, "primary_camera.xml,projector.xml"));
  EXPECT_NO_THROW(require_valid(sensor));
  EXPECT_EQ(sensor.projector.size, (Size{1824, 1140}));
  EXPECT_NEAR(sensor.translation.y(), -128.53, 0.01);
}

}  // namespace slipstream::scanner_names_test
