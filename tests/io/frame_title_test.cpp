#include "io/frame_title.h"

#include <array>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/numbers.h"
#include "geometry/rotation.h"
#include "io/file.h"
#include "io/result_files.h"
#include "slipstream/cloud_file.h"
#include "tests/io/sheet_cloud.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::frame_title_test {

std::shared_ptr<const FramePose> base_pose() {
  return std::make_shared<const FramePose>(
      FramePose{"camera", "robot_base",
                pose_from(rotation_of_euler({170 * degree, -20 * degree, 35 * degree}, {}),
                          {900, -250, 1400})});
}

/// The expected points in any order, each with the nearest of the file.
double largest_distance(const Cloud& expected, const Cloud& found) {
  double largest = 0;
  for_each_pixel_in_order(expected.size(), [&](int column, int row) {
    if (expected.validity(column, row) != Validity::valid) return;
    double nearest = std::numeric_limits<double>::infinity();
    for_each_pixel_in_order(found.size(), [&](int other, int line) {
      if (found.validity(other, line) != Validity::valid) return;
      const Eigen::Vector3d apart = position_at(expected, column, row) - position_at(found, other, line);
      nearest = std::min(nearest, apart.norm());
    });
    largest = std::max(largest, nearest);
  });
  return largest;
}

class FrameTitleFrameInFile : public testing::TestWithParam<const char*> {};

TEST_P(FrameTitleFrameInFile, NamesItsFrameAndHasItsPoints) {
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / ("moved" + std::string(GetParam()));
  const std::shared_ptr<const FramePose> frame = base_pose();
  const bool is_cloud = std::string(GetParam()) == ".pcd" || std::string(GetParam()) == ".xyz";

  ResultFiles files;
  (is_cloud ? files.cloud : files.mesh) = file.string();
  write_results(files, sheet_cloud(), {}, {.frame = frame});

  const StoredCloud stored = read_cloud(file);
  Cloud expected = sheet_cloud();
  move_to_frame(expected, *frame);
  EXPECT_LT(largest_distance(expected, stored.cloud), 1e-2);

  // Text of columns has no header.
  if (std::string(GetParam()) == ".xyz") return;
  EXPECT_EQ(frame_name(stored.cloud), "robot_base");
  EXPECT_EQ(read_text(file).find("camera frame"), std::string::npos);
  EXPECT_EQ(stored.organised, is_cloud);

  // STL has no place for more than the name.
  if (std::string(GetParam()) == ".stl") return;
  EXPECT_TRUE(stored.cloud.frame->transform.isApprox(frame->transform, 1e-9));
}

INSTANTIATE_TEST_SUITE_P(Formats, FrameTitleFrameInFile,
                         testing::Values(".ply", ".pcd", ".xyz", ".stl", ".obj", ".glb"));

TEST(FrameTitle, CloudInPlyHasNormalsAndSigmaOfTheFrame) {
  const TemporaryFolder folder;
  const Cloud given = sheet_cloud();
  const std::shared_ptr<const FramePose> frame = base_pose();
  const Normals normals = surface_normals(given);
  Uncertainty sigma(given.size());
  for (Image<float>* image : {&sigma.coordinate, &sigma.x, &sigma.y, &sigma.z}) {
    std::fill(image->begin(), image->end(), 0.1F);
  }
  write_cloud(folder.path() / "moved.ply", given,
              {.normals = &normals, .uncertainty = &sigma, .frame = frame});

  const std::string file = read_text(folder.path() / "moved.ply");
  EXPECT_NE(file.find("comment slipstream, robot_base frame, mm\n"), std::string::npos);
  EXPECT_NE(file.find("comment viewpoint 900 -250 1400 "), std::string::npos);

  const StoredCloud stored = read_cloud(folder.path() / "moved.ply");
  ASSERT_TRUE(stored.uncertainty);
  const Eigen::Vector3d turned(stored.uncertainty->x(0, 0), stored.uncertainty->y(0, 0),
                               stored.uncertainty->z(0, 0));
  EXPECT_NEAR(turned.norm(), 0.1 * std::sqrt(3.0), 1e-6);
  EXPECT_FLOAT_EQ(stored.uncertainty->coordinate(0, 0), 0.1F);
}

TEST(FrameTitle, CameraFrameIsWrittenAsBefore) {
  const TemporaryFolder folder;
  write_cloud(folder.path() / "cloud.ply", sheet_cloud());
  const std::string file = read_text(folder.path() / "cloud.ply");
  EXPECT_NE(file.find("1.0\ncomment slipstream, camera frame, mm\nelement"), std::string::npos);
  EXPECT_EQ(frame_name(read_cloud(folder.path() / "cloud.ply").cloud), camera_frame);

  write_cloud(folder.path() / "cloud.pcd", sheet_cloud());
  EXPECT_NE(read_text(folder.path() / "cloud.pcd").find("VIEWPOINT 0 0 0 1 0 0 0\n"),
            std::string::npos);
}

TEST(FrameTitle, NodeOfGltfTurnsZUpAndNamesTheFrame) {
  const TemporaryFolder folder;
  write_results({.mesh = (folder.path() / "mesh.glb").string()}, sheet_cloud(), {},
                {.frame = base_pose()});

  const std::string file = read_text(folder.path() / "mesh.glb");
  const std::size_t begin = file.find('{'),
                    length = number_at<std::uint32_t>(
                        std::span(reinterpret_cast<const std::uint8_t*>(file.data()), file.size()),
                        12);
  const auto document = nlohmann::json::parse(file.substr(begin, length));
  const auto& node = document["nodes"][0];
  EXPECT_EQ(node["name"], "robot_base");
  EXPECT_EQ(node["extras"]["slipstream_frame"], "robot_base");

  // The frame's z becomes the y of glTF, which is up.
  const auto turn = node["rotation"].get<std::array<double, 4>>();
  const Eigen::Vector3d up =
      rotation_of_quaternion(Eigen::Vector4d(turn.data()), QuaternionOrder::xyzw) *
      Eigen::Vector3d::UnitZ();
  EXPECT_LT((up - Eigen::Vector3d::UnitY()).norm(), 1e-12);
}

TEST(FrameTitle, IgnoresDamagedLines) {
  FrameTitle title;
  title.read("slipstream, two words frame, mm");
  EXPECT_EQ(title.frame(), nullptr);

  FrameTitle other;
  other.read("# .PCD v0.7 - slipstream, base frame, mm");
  other.read("VIEWPOINT 1 2 nan 1 0 0 0");
  ASSERT_NE(other.frame(), nullptr);
  EXPECT_EQ(other.frame()->to, "base");
  EXPECT_TRUE(other.frame()->transform.isApprox(Eigen::Isometry3d::Identity()));
}

}  // namespace slipstream::frame_title_test
