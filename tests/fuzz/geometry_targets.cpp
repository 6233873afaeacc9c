// Clouds and meshes.
#include "io/file.h"
#include "simulate/virtual_files.h"
#include "slipstream/cloud_file.h"
#include "tests/fuzz/target.h"
#include "tests/io/sheet_cloud.h"

namespace slipstream {
namespace {
namespace fs = std::filesystem;

Cloud few_points() {
  Cloud cloud({3, 2});
  for (int i = 1; i < 6; ++i) {
    cloud.x.begin()[i] = cloud.y.begin()[i] = static_cast<float>(i);
    cloud.z.begin()[i] = 500;
    cloud.validity.begin()[i] = Validity::valid;
  }
  return cloud;
}

/// As write_cloud and write_surface write such files, and others.
std::vector<Bytes> files_of_ending(const std::string& ending,
                                   const std::vector<std::string>& more) {
  std::vector<Bytes> seeds;
  for (const std::string& text : more) seeds.push_back(bytes_of(text));
  const Cloud cloud = few_points();
  const Uncertainty sigma(cloud.size());
  if (ending != ".stl" && ending != ".obj" && ending != ".glb") {
    seeds.push_back(written_file("cloud" + ending, [&](const fs::path& path) {
      write_cloud(path, cloud, {.uncertainty = &sigma});
    }));
  }
  if (ending != ".pcd" && ending != ".xyz") {
    seeds.push_back(written_file("surface" + ending, [&](const fs::path& path) {
      write_surface(path, surface_of(sheet_cloud()));
    }));
  }
  return seeds;
}

const std::string ascii_ply =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nproperty uchar red\nproperty float intensity\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n"
    "0 0 500 3 17\n1 0 501.5 4 18\nnan 1 2 3 4\n3 0 1 2\n";
const std::string ascii_mesh =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
    "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    "0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n";
const std::string ascii_pcd =
    "# .PCD v0.7\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
    "WIDTH 2\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n0 0 500 17\n1 0 nan 18\n";
const std::string mixed_pcd =
    "VERSION 0.7\nFIELDS t x y z _ rgb\nSIZE 8 4 8 2 1 4\nTYPE U F F I U F\nCOUNT 1 1 1 1 2 1\n"
    "WIDTH 1\nHEIGHT 2\nPOINTS 2\nDATA ascii\n7 1 2 3 0 0 1e-40\n8 1 2 3 0 0 4210752\n";
const std::string named_xyz = "2\n// X Y Z R G B\n1,2,3,0,100,0\n4,5,6,200,130,45\n";

bool add_cloud_target(const std::string& ending, const std::vector<std::string>& more) {
  return add_fuzz_target({"cloud" + ending, [=] { return files_of_ending(ending, more); },
                          [=](std::span<const std::uint8_t> input) {
                            (void)read_cloud(file_of(input, "cloud" + ending));
                          }});
}

bool add_mesh_target(const std::string& ending, const std::vector<std::string>& more) {
  const auto seeds = [=] {
    std::vector<Bytes> all{written_file("mesh" + ending, [&](const fs::path& path) {
      write_surface(path, surface_of(sheet_cloud()));
    })};
    for (const std::string& text : more) all.push_back(bytes_of(text));
    return all;
  };
  return add_fuzz_target({"mesh" + ending, seeds, [=](std::span<const std::uint8_t> input) {
                            (void)read_mesh(file_of(input, "mesh" + ending));
                          }});
}

const std::string triangle =
    "v 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\ng part\nf 1 2 3\nf -3//1 -2//1 -1//1\n";

const bool knows_geometry_targets =
    add_cloud_target(".ply", {ascii_ply}) && add_cloud_target(".pcd", {ascii_pcd, mixed_pcd}) &&
    add_cloud_target(".xyz", {"0 0 500\n1 0 501\n", named_xyz}) && add_cloud_target(".stl", {}) &&
    add_cloud_target(".obj", {triangle}) && add_cloud_target(".glb", {}) &&
    add_mesh_target(".ply", {ascii_mesh}) && add_mesh_target(".obj", {triangle});

}  // namespace
}  // namespace slipstream
