#include <array>
#include <cstdint>
#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include "io/file.h"
#include "simulate/virtual_files.h"
#include "slipstream/cloud_file.h"
#include "tests/io/expect_error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::mesh_file_test {

TEST(MeshFile, ReadsPlyAndObj) {
  const TemporaryFolder folder;
  write_file(folder.path() / "square.ply",
             "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\n"
             "property float z\nelement face 2\nproperty list uchar int vertex_indices\n"
             "end_header\n0 0 0\n1 0 0\n1 1 0\n0 1 0.5\n3 0 1 2\n3 0 2 3\n");
  write_file(folder.path() / "square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nf 1 2 3 4\n");
  for (const char* name : {"square.ply", "square.obj"}) {
    const Mesh mesh = read_mesh(folder.path() / name);
    EXPECT_EQ(mesh.triangles.size(), 2U) << name;
    double top = 0;
    for (const auto& vertex : mesh.vertices) top = std::max(top, vertex.z());
    EXPECT_EQ(top, 0.5);
  }
}

TEST(MeshFile, TakesTheLuminanceOfColouredVertices) {
  const TemporaryFolder folder;
  write_file(folder.path() / "coloured.obj",
             "v 0 0 5 1 0 0\nv 1 0 5 0 1 0\nv 1 1 5 0 0 1\nf 1 2 3\n");
  const Cloud cloud = read_cloud(folder.path() / "coloured.obj").cloud;
  ASSERT_EQ(cloud.intensity.pixel_count(), 3U);
  EXPECT_NEAR(cloud.intensity(0, 0), 255 * 0.299, 0.01);
  EXPECT_NEAR(cloud.intensity(1, 0), 255 * 0.587, 0.01);
  EXPECT_NEAR(cloud.intensity(2, 0), 255 * 0.114, 0.01);
}

template <class Number>
void append_big_endian(std::string& bytes, Number number) {
  std::array<char, sizeof(Number)> raw;
  std::memcpy(raw.data(), &number, sizeof(Number));
  bytes.append(raw.rbegin(), raw.rend());
}

TEST(MeshFile, ReadsBinaryPlyOfTheOtherByteOrderAndPassesOverTheRest) {
  const TemporaryFolder folder;
  std::string ply =
      "ply\r\nformat binary_big_endian 1.0\r\ncomment made by hand\r\nelement vertex 3\r\n"
      "property uchar red\r\nproperty double x\r\nproperty float y\r\nproperty short z\r\n"
      "element face 1\r\nproperty list uchar uint vertex_index\r\nproperty int flags\r\n"
      "end_header\r\n";
  for (int i = 0; i < 3; ++i) {
    append_big_endian<std::uint8_t>(ply, 200);
    append_big_endian<double>(ply, 0.5 * i);
    append_big_endian<float>(ply, 1.25F);
    append_big_endian<std::int16_t>(ply, static_cast<std::int16_t>(-300 * i));
  }
  append_big_endian<std::uint8_t>(ply, 3);
  for (std::uint32_t i = 0; i < 3; ++i) append_big_endian(ply, i);
  append_big_endian<std::int32_t>(ply, 7);
  write_file(folder.path() / "mesh.ply", ply);
  const Mesh mesh = read_mesh(folder.path() / "mesh.ply");
  ASSERT_EQ(mesh.vertices.size(), 3U);
  EXPECT_EQ(mesh.vertices[2], Eigen::Vector3d(1, 1.25, -600));
  EXPECT_EQ(mesh.triangles.at(0), (std::array{0, 1, 2}));
}

TEST(MeshFile, BadOnesAreNamed) {
  const TemporaryFolder folder;
  write_file(folder.path() / "points.obj", "v 0 0 0\nv 1 0 0\n");
  write_file(folder.path() / "text.ply", "no mesh");
  expect_error([&] { read_mesh(folder.path() / "none.ply"); }, {"none.ply"});
  expect_error([&] { read_mesh(folder.path() / "points.obj"); }, {"points.obj", "triangle"});
  expect_error([&] { read_mesh(folder.path() / "text.ply"); }, {"text.ply"});
  expect_error([&] { read_mesh(folder.path() / "mesh.stl"); }, {".stl", ".ply"});
}

}  // namespace slipstream::mesh_file_test
