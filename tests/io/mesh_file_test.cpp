#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <string>

#include <Eigen/Geometry>
#include <fmt/format.h>
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
  const std::string obj = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.5\nf 1 2 3 4\n";
  write_file(folder.path() / "square.obj", obj);
  write_file(folder.path() / "marked.obj", "\xEF\xBB\xBF" + obj);
  for (const char* name : {"square.ply", "square.obj", "marked.obj"}) {
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

/// A binary glTF file of that description, with `points` points at (1, 1, 1) m.
std::string glb_file(std::string json, int points) {
  json.resize((json.size() + 3) / 4 * 4, ' ');
  std::string binary;
  for (int i = 0; i < 3 * points; ++i) binary += std::string("\0\0\x80\x3f", 4);

  std::string file = "glTF";
  const auto append = [&](std::size_t number) {
    for (int bits = 0; bits < 32; bits += 8) file += static_cast<char>(number >> bits & 0xFF);
  };
  for (const std::size_t number : {std::size_t{2}, json.size() + binary.size() + 28, json.size()}) {
    append(number);
  }
  file += "JSON" + json;
  append(binary.size());
  return file + std::string("BIN\0", 4) + binary;
}

/// A mesh of that many primitives. Each has the same vertices, by its own accessor or by one.
std::string repeated_vertices(int primitives, int points, bool own_accessors) {
  std::string accessors, parts;
  for (int n = 0; n < primitives; ++n) {
    const std::string comma = n == 0 ? "" : ",";
    parts += fmt::format(R"({}{{"attributes":{{"POSITION":{}}}}})", comma, own_accessors ? n : 0);
    accessors +=
        fmt::format(R"({}{{"bufferView":0,"componentType":5126,"count":{}}})", comma, points);
  }

  return glb_file(fmt::format(R"({{"accessors":[{}],"bufferViews":[{{"byteLength":{}}}],)"
                              R"("meshes":[{{"primitives":[{}]}}]}})",
                              accessors, 12 * points, parts),
                  points);
}

TEST(MeshFile, VerticesSharedByPrimitivesAreTakenOnce) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "shared.glb";
  write_file(path, repeated_vertices(200, 50, false));
  EXPECT_EQ(read_points(path).points.size(), 50U);
}

TEST(MeshFile, HasNoMorePointsThanItsBytesHold) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "overlapping.glb";
  write_file(path, repeated_vertices(200, 50, true));
  expect_error([&] { (void)read_points(path); }, {"overlapping.glb", "600 bytes"});
}

TEST(MeshFile, IntensitiesAreAsManyAsVertices) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "few.glb";
  write_file(path, glb_file(R"({"accessors":[{"bufferView":0,"componentType":5126,"count":2},)"
                            R"({"bufferView":0,"componentType":5126,"count":1}],)"
                            R"("bufferViews":[{"byteLength":24}],"meshes":[{"primitives":)"
                            R"([{"attributes":{"POSITION":0,"_INTENSITY":1}}]}]})",
                            2));
  expect_error([&] { (void)read_points(path); }, {"few.glb", "2 vertices", "1 intensities"});
}

TEST(MeshFile, FaceOfManyCornersIsAFan) {
  constexpr int corners = 5000;
  std::string obj, face = "f";
  for (int i = 0; i < corners; ++i) {
    obj += fmt::format("v {} {} 5\n", std::cos(i * 2e-4), std::sin(i * 2e-4));
    face += fmt::format(" {}/1", i - corners);  // counted from the last vertex
  }

  const TemporaryFolder folder;
  const auto path = folder.path() / "disc.obj";
  write_file(path, obj + "vt 0 0\n" + face + "\n");

  // An exact cut, which takes the square of the corners, has other triangles.
  const Mesh mesh = read_mesh(path);
  ASSERT_EQ(mesh.triangles.size(), std::size_t{corners - 2});
  for (int n = 0; n < corners - 2; ++n) {
    ASSERT_EQ(mesh.triangles[static_cast<std::size_t>(n)], (std::array{0, n + 1, n + 2}));
  }
}

TEST(MeshFile, ConcaveFaceOfFewCornersIsCutInside) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "crown.obj";
  write_file(path, "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 2 1 0\nv 0 4 0\nf 1 2 3 4 5\n");

  double area = 0;
  const Mesh mesh = read_mesh(path);
  for (const auto& [i, j, k] : mesh.triangles) {
    const auto at = [&](int n) { return mesh.vertices[static_cast<std::size_t>(n)]; };
    area += (at(j) - at(i)).cross(at(k) - at(i)).norm() / 2;
  }
  EXPECT_NEAR(area, 10, 1e-9);
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
