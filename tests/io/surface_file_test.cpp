#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "io/file.h"
#include "simulate/virtual_files.h"
#include "slipstream/cloud_file.h"
#include "tests/io/expect_error.h"
#include "tests/io/grey_image.h"
#include "tests/io/sheet_cloud.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::surface_file_test {

/// X, Y, Z and intensity of each point, sorted.
using Sorted = std::vector<std::array<float, 4>>;

Sorted sorted(const Surface& surface, bool with_intensity) {
  Sorted all;
  for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
    const Eigen::Vector3f& at = surface.vertices[i];
    all.push_back({at.x(), at.y(), at.z(), with_intensity ? surface.intensity[i] : 0});
  }
  std::sort(all.begin(), all.end());
  return all;
}

Sorted sorted(const Cloud& cloud) {
  Sorted all;
  for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
    all.push_back(
        {cloud.x.begin()[i], cloud.y.begin()[i], cloud.z.begin()[i], cloud.intensity.begin()[i]});
  }
  std::sort(all.begin(), all.end());
  return all;
}

class SurfaceFile : public testing::TestWithParam<const char*> {};

TEST_P(SurfaceFile, IsReadAsItsVertices) {
  const TemporaryFolder folder;
  const auto path = folder.path() / (std::string("mesh") + GetParam());
  const Surface surface = surface_of(sheet_cloud());
  write_surface(path, surface);
  const StoredCloud stored = read_cloud(path);
  EXPECT_FALSE(stored.organised);
  const Sorted written = sorted(surface, std::string(GetParam()) != ".stl");
  const Sorted read = sorted(stored.cloud);
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    for (std::size_t k = 0; k < 3; ++k) ASSERT_NEAR(read[i][k], written[i][k], 1e-4) << i;
    ASSERT_NEAR(read[i][3], written[i][3], 2e-3) << i;
  }
}

INSTANTIATE_TEST_SUITE_P(Ending, SurfaceFile, testing::Values(".ply", ".stl", ".obj", ".glb"),
                         [](const auto& info) { return std::string(info.param).substr(1); });

TEST(SurfaceFiles, PlyAndObjHaveTheTriangles) {
  const TemporaryFolder folder;
  const Surface surface = surface_of(sheet_cloud());
  for (const char* const name : {"mesh.ply", "mesh.obj"}) {
    write_surface(folder.path() / name, surface);
    const Mesh mesh = read_mesh(folder.path() / name);
    ASSERT_EQ(mesh.triangles.size(), surface.triangles.size());
    for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
      for (std::size_t k = 0; k < 3; ++k) {
        ASSERT_EQ(static_cast<std::uint32_t>(mesh.triangles[i][k]), surface.triangles[i][k]);
      }
    }
  }
}

TEST(SurfaceFiles, ObjHasItsPictureBesideIt) {
  const TemporaryFolder folder;
  const Cloud cloud = sheet_cloud();
  write_surface(folder.path() / "mesh.obj", surface_of(cloud));
  EXPECT_EQ(entries_in(folder.path()), 3);
  const Image<std::uint16_t> picture = read_grey_image(folder.path() / "mesh-texture.png");
  ASSERT_EQ(picture.size(), cloud.size());
  EXPECT_TRUE(std::equal(picture.begin(), picture.end(), cloud.intensity.begin()));
}

TEST(SurfaceFiles, GlbOfOthersMayBeginWithinAView) {
  const TemporaryFolder folder;
  std::string json =
      R"({"accessors":[{"bufferView":0,"byteOffset":12,"componentType":5126,"count":1}],)"
      R"("bufferViews":[{"byteLength":24}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}]})";
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string file = "glTF";
  const auto append = [&](std::size_t number) {
    for (int bits = 0; bits < 32; bits += 8) file += static_cast<char>(number >> bits & 0xFF);
  };
  for (const std::size_t number : {std::size_t{2}, json.size() + 52, json.size()}) append(number);
  file += "JSON" + json;
  append(24);
  file += std::string("BIN\0", 4);
  for (const float number : {1.0F, 2.0F, 3.0F, 4.0F, 5.0F, -6.0F}) {
    append(std::bit_cast<std::uint32_t>(number));
  }
  write_file(folder.path() / "mesh.glb", file);
  const Cloud cloud = read_cloud(folder.path() / "mesh.glb").cloud;
  ASSERT_EQ(cloud.size(), (Size{1, 1}));
  EXPECT_EQ(cloud.x(0, 0), 4000);
  EXPECT_EQ(cloud.y(0, 0), -5000);
  EXPECT_EQ(cloud.z(0, 0), 6000);
}

TEST(SurfaceFiles, RefuseWhatTheyCannotHold) {
  const TemporaryFolder folder;
  const Surface surface = surface_of(sheet_cloud());
  expect_error([&] { write_surface(folder.path() / "mesh.fbx", surface); },
               {".fbx", ".ply, .stl, .obj, .glb"});
  expect_error(
      [&] {
        write_surface(folder.path() / "mesh.glb", surface_of(Cloud({9, 9})));
      },
      {"mesh.glb", "neighbouring"});
  EXPECT_EQ(entries_in(folder.path()), 0);
  write_file(folder.path() / "mesh.fbx", "");
  expect_error([&] { (void)read_cloud(folder.path() / "mesh.fbx"); }, {".fbx", ".glb"});
}

}  // namespace slipstream::surface_file_test
