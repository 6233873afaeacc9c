#include "slipstream/cloud_file.h"

#include <cmath>
#include <cstring>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include "io/file.h"
#include "io/image_file.h"
#include "io/plot.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::cloud_file_test {

/// Three points in a 3x2 image.
Cloud small_cloud() {
  Cloud cloud({3, 2});
  int i = 0;
  for (const auto [column, row] : {std::pair(0, 0), std::pair(2, 0), std::pair(1, 1)}) {
    cloud.x(column, row) = i + 0.25;
    cloud.y(column, row) = -i;
    cloud.z(column, row) = 500.5 + i;
    cloud.intensity(column, row) = static_cast<float>(10 * i);
    cloud.validity(column, row) = Validity::valid;
    ++i;
  }
  return cloud;
}

struct Parsed {
  std::string header;
  std::string bytes;  ///< after the header

  [[nodiscard]] std::vector<float> floats() const {
    std::vector<float> numbers(bytes.size() / sizeof(float));
    std::memcpy(numbers.data(), bytes.data(), numbers.size() * sizeof(float));
    return numbers;
  }
};

Parsed parse(const std::filesystem::path& path, const std::string& end_of_header) {
  const auto bytes = read_file(path);
  const std::string text(bytes.begin(), bytes.end());
  const std::size_t end = text.find(end_of_header) + end_of_header.size();
  return {text.substr(0, end), text.substr(end)};
}

TEST(CloudFile, PlyHasTheValidPointsAndNoWordOfTheOthers) {
  const TemporaryFolder folder;
  write_cloud(folder.path() / "cloud.ply", small_cloud());
  const auto [header, bytes] = parse(folder.path() / "cloud.ply", "end_header\n");
  EXPECT_NE(header.find("element vertex 3\n"), std::string::npos);
  // With obj_info, the Point Cloud Library reads one point per pixel, most of them at the origin.
  EXPECT_EQ(header.find("obj_info"), std::string::npos);
  ASSERT_EQ(bytes.size(), 3 * (3 * sizeof(float) + sizeof(double) + 3));
  EXPECT_EQ(bytes.substr(23 + 20, 3), "\x0a\x0a\x0a");
}

/// A cloud with scattered points and a value in every field that a file can store.
struct FullCloud {
  explicit FullCloud(unsigned seed) : cloud({17, 11}), sigma(cloud.size()) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> number(-400, 400);
    for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
      cloud.intensity.begin()[i] = static_cast<float>(random() % 256);
      if (i != 3 && random() % 3 == 0) continue;
      cloud.x.begin()[i] = number(random);
      cloud.y.begin()[i] = number(random);
      cloud.z.begin()[i] = 600 + number(random);
      cloud.validity.begin()[i] = Validity::valid;
      sigma.z.begin()[i] = 0.1F;
    }
    normals = surface_normals(cloud);
  }
  Cloud cloud;
  Uncertainty sigma;
  Normals normals;
};

RC_GTEST_PROP(CloudFile, WhatIsWrittenIsRead, (unsigned seed, bool with_normals, bool with_sigma)) {
  const TemporaryFolder folder;
  const FullCloud written(seed);
  const CloudExtras extras{.normals = with_normals ? &written.normals : nullptr,
                           .uncertainty = with_sigma ? &written.sigma : nullptr};
  for (const char* const name : {"cloud.ply", "cloud.pcd", "cloud.xyz"}) {
    write_cloud(folder.path() / name, written.cloud, extras);
    const StoredCloud read = read_cloud(folder.path() / name);
    const bool organised = name == std::string("cloud.pcd");
    RC_ASSERT(read.organised == organised);
    RC_ASSERT(read.uncertainty.has_value() == with_sigma);
    if (organised) RC_ASSERT(read.cloud.size() == written.cloud.size());
    RC_ASSERT(point_count(read.cloud) == point_count(written.cloud));
    std::size_t at = 0;
    for (std::size_t i = 0; i < written.cloud.z.pixel_count(); ++i) {
      if (written.cloud.validity.begin()[i] != Validity::valid) continue;
      while (read.cloud.validity.begin()[at] != Validity::valid) ++at;
      RC_ASSERT(std::abs(read.cloud.x.begin()[at] - written.cloud.x.begin()[i]) < 1e-4);
      RC_ASSERT(std::abs(read.cloud.y.begin()[at] - written.cloud.y.begin()[i]) < 1e-4);
      RC_ASSERT(std::abs(read.cloud.z.begin()[at] - written.cloud.z.begin()[i]) < 1e-4);
      RC_ASSERT(read.cloud.intensity.begin()[at] == written.cloud.intensity.begin()[i]);
      if (with_sigma) RC_ASSERT(read.uncertainty->z.begin()[at] == 0.1F);
      if (organised) RC_ASSERT(at == i);
      ++at;
    }
  }
}

TEST(CloudFile, ReadsCloudsOfOthers) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "cloud.ply";
  write_file(path,
             "ply\nformat ascii 1.0\nelement vertex 3\nproperty uchar red\nproperty uchar green\n"
             "property uchar blue\nproperty double z\nproperty double y\nproperty double x\n"
             "end_header\n200 200 200 3 2 1\n0 0 0 nan 2 1\n0 100 0 6 5 4\n");
  const Cloud cloud = read_cloud(path).cloud;
  ASSERT_EQ(cloud.size(), (Size{2, 1}));
  EXPECT_EQ(cloud.x(1, 0), 4);
  EXPECT_EQ(cloud.z(1, 0), 6);
  EXPECT_NEAR(cloud.intensity(0, 0), 200, 1e-4);
  EXPECT_NEAR(cloud.intensity(1, 0), 58.7, 1e-4);
}

TEST(CloudFile, RefusesWhatIsNoCloud) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "cloud.ply";
  const std::string begin = "ply\nformat ascii 1.0\nelement vertex ";
  const std::string x_and_y = "\nproperty float x\nproperty float y\n";
  write_file(path, begin + "0" + x_and_y + "property float z\nend_header\n");
  expect_error([&] { read_cloud(path); }, {path.string(), "no point"});
  write_file(path, begin + "1" + x_and_y + "end_header\n1 2\n");
  expect_error([&] { read_cloud(path); }, {path.string(), "no x, y and z"});
  write_file(path, "solid\n");
  expect_error([&] { read_cloud(path); }, {path.string(), "'ply'"});
  expect_error([&] { read_cloud(folder.path() / "missing.ply"); }, {"missing.ply"});
  expect_error([&] { read_cloud(folder.path() / "missing.ply"); }, {"missing.ply: no such file"});
}

TEST(CloudFile, PlyTakesNormals) {
  const TemporaryFolder folder;
  const Cloud cloud = small_cloud();
  const Normals normals = surface_normals(cloud);
  write_cloud(folder.path() / "cloud.ply", cloud, {.normals = &normals});
  const auto [header, bytes] = parse(folder.path() / "cloud.ply", "end_header\n");
  EXPECT_NE(header.find("property float nz\n"), std::string::npos);
  EXPECT_EQ(bytes.size(), 3U * (6 * 4 + 8 + 3));
}

TEST(CloudFile, PlyAndPcdTakeUncertainty) {
  const TemporaryFolder folder;
  const Cloud cloud = small_cloud();
  Uncertainty sigma(cloud.size());
  sigma.z(0, 0) = 0.125F;
  write_cloud(folder.path() / "cloud.ply", cloud, {.uncertainty = &sigma});
  const Parsed ply = parse(folder.path() / "cloud.ply", "end_header\n");
  EXPECT_NE(ply.header.find("property float sigma_z\n"), std::string::npos);
  EXPECT_EQ(ply.bytes.size(), 3U * (7 * 4 + 8 + 3));
  EXPECT_EQ(ply.floats()[8], 0.125F);
  write_cloud(folder.path() / "cloud.pcd", cloud, {.uncertainty = &sigma});
  const Parsed pcd = parse(folder.path() / "cloud.pcd", "DATA binary\n");
  EXPECT_NE(pcd.header.find("sigma_coordinate sigma_x sigma_y sigma_z\n"), std::string::npos);
  EXPECT_EQ(pcd.floats().size(), 48U);
}

TEST(CloudFile, KeepsSystematicErrorsBesideUncertainty) {
  const TemporaryFolder folder;
  const Cloud cloud = small_cloud();
  Uncertainty sigma(cloud.size());
  sigma.z_systematic = Image<float>(cloud.size(), 0.25F);
  sigma.z(0, 0) = 0.125F;

  for (const char* const name : {"cloud.ply", "cloud.pcd"}) {
    write_cloud(folder.path() / name, cloud, {.uncertainty = &sigma});
    const StoredCloud stored = read_cloud(folder.path() / name);
    ASSERT_TRUE(stored.uncertainty);
    EXPECT_EQ(stored.uncertainty->z(0, 0), 0.125F);
    ASSERT_FALSE(stored.uncertainty->z_systematic.empty());
    EXPECT_EQ(stored.uncertainty->z_systematic(0, 0), 0.25F);
  }

  // Text has no names of columns, so that it keeps the usual ones.
  write_cloud(folder.path() / "cloud.xyz", cloud, {.uncertainty = &sigma});
  EXPECT_EQ(read_cloud(folder.path() / "cloud.xyz").uncertainty->z(0, 0), 0.125F);
}

TEST(CloudFile, RemarksAreCommentsOfTheHeader) {
  const TemporaryFolder folder;
  const CloudExtras remarked{.remarks = {"doubted: {frames}\nswapped", "b"}};
  write_cloud(folder.path() / "cloud.ply", small_cloud(), remarked);
  EXPECT_NE(parse(folder.path() / "cloud.ply", "end_header\n")
                .header.find("\ncomment doubted: {frames} swapped\ncomment b\n"),
            std::string::npos);
  EXPECT_EQ(point_count(read_cloud(folder.path() / "cloud.ply").cloud), 3U);
  write_cloud(folder.path() / "cloud.pcd", small_cloud(), remarked);
  const auto [header, bytes] = parse(folder.path() / "cloud.pcd", "DATA binary\n");
  EXPECT_TRUE(header.starts_with("# .PCD v0.7"));
  EXPECT_NE(header.find("\n# doubted: {frames} swapped\n# b\nVERSION 0.7\n"), std::string::npos);
  EXPECT_EQ(bytes.size(), 96U);
  write_cloud(folder.path() / "cloud.xyz", small_cloud(), remarked);
}

TEST(CloudFile, PcdIsOrganised) {
  const TemporaryFolder folder;
  write_cloud(folder.path() / "cloud.pcd", small_cloud());
  const Parsed pcd = parse(folder.path() / "cloud.pcd", "DATA binary\n");
  EXPECT_NE(pcd.header.find("WIDTH 3\nHEIGHT 2\n"), std::string::npos);
  const std::vector<float> floats = pcd.floats();
  ASSERT_EQ(floats.size(), 24U);
  EXPECT_TRUE(std::isnan(floats[4]));
  EXPECT_EQ(floats[8], 1.25F);
}

TEST(CloudFile, XyzIsText) {
  const TemporaryFolder folder;
  write_cloud(folder.path() / "cloud.xyz", small_cloud());
  const auto bytes = read_file(folder.path() / "cloud.xyz");
  std::istringstream text(std::string(bytes.begin(), bytes.end()));
  std::vector<double> numbers{std::istream_iterator<double>(text), {}};
  ASSERT_EQ(numbers.size(), 12U);
  EXPECT_EQ(numbers[6], 501.5);
}

TEST(CloudFile, OtherEndingsAreRefused) {
  const TemporaryFolder folder;
  expect_error([&] { write_cloud(folder.path() / "cloud.las", small_cloud()); }, {".las", ".ply"});
  EXPECT_EQ(entries_in(folder.path()), 0);
}

TEST(CloudFilePreview, IsAPictureWithAScaleBesideIt) {
  const TemporaryFolder folder;
  write_depth_preview(folder.path() / "preview.png", small_cloud());
  const LoadedFrames loaded = read_frames({folder.path() / "preview.png"});
  EXPECT_GT(loaded.frames.size().width, 100);
  write_map_preview(folder.path() / "map.png", Image<double>({300, 200}, std::nan("")), "rad");
  expect_error([&] { write_depth_preview(folder.path() / "preview.jpg", small_cloud()); },
               {".png"});
}

TEST(CloudFilePreview, RangeLeavesOutOutliers) {
  Image<double> map({100, 100}, 5.0);
  for (int i = 0; i < 50; ++i) map(i, 0) = 1e6;
  const ValueRange range = robust_range(map);
  EXPECT_LT(range.low, 5);
  EXPECT_GT(range.high, 5);
  EXPECT_LT(range.high, 6);
}

}  // namespace slipstream::cloud_file_test
