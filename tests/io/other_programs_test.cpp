// Reads written files with other programs; skipped if they are not installed.
//
// apt-get install pcl-tools python3-open3d meshlab cloudcompare xvfb nodejs npm
// npm install gltf-validator
// NODE_PATH=node_modules ctest --test-dir build -R OtherProgram -V
//
// docs/reference/clouds-and-recordings.md lists the versions that were tested.
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <sstream>
#include <string>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "slipstream/cloud_file.h"
#include "tests/io/sheet_cloud.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::other_programs_test {

class OtherPrograms : public testing::Test {
 protected:
  [[nodiscard]] std::string path(const std::string& name) const { return folder_.path() / name; }

  /// Runs a command in the folder; returns whether it succeeded.
  [[nodiscard]] bool run(const std::string& command) const {
    return std::system(
               fmt::format("cd {} && ({}) >said 2>&1", folder_.path().string(), command).c_str()) ==
           0;
  }
  [[nodiscard]] bool has(const std::string& program) const { return run("command -v " + program); }
  [[nodiscard]] std::string said() const {
    std::ifstream file(path("said"));
    return {std::istreambuf_iterator<char>(file), {}};
  }

  const Cloud cloud_ = sheet_cloud();

 private:
  TemporaryFolder folder_;
};

TEST_F(OtherPrograms, PclReadsExactlyTheValidPoints) {
  if (!has("pcl_ply2pcd")) GTEST_SKIP() << "no pcl_ply2pcd; it is in Debian's pcl-tools";
  write_cloud(path("cloud.ply"), cloud_);
  ASSERT_TRUE(run("pcl_ply2pcd cloud.ply read.pcd && pcl_pcd2ply -format 0 read.pcd back.ply"))
      << said();
  const StoredCloud read = read_cloud(path("back.ply"));
  ASSERT_EQ(point_count(read.cloud), point_count(cloud_));
  std::size_t at = 0;
  for (std::size_t i = 0; i < cloud_.z.pixel_count(); ++i) {
    if (cloud_.validity.begin()[i] != Validity::valid) continue;
    EXPECT_NEAR(read.cloud.z.begin()[at], cloud_.z.begin()[i], 1e-3);
    EXPECT_EQ(read.cloud.intensity.begin()[at], cloud_.intensity.begin()[i]);
    ++at;
  }
}

// Colours of .ply and of .pcd go through PCL to a .ply, in which they are bytes again.
TEST_F(OtherPrograms, PclReadsTheColoursOfThePicture) {
  if (!has("pcl_ply2pcd")) GTEST_SKIP() << "no pcl_ply2pcd; it is in Debian's pcl-tools";
  const Cloud coloured = coloured_sheet_cloud();
  write_cloud(path("from-ply.ply"), coloured);
  write_cloud(path("from-pcd.pcd"), coloured);
  ASSERT_TRUE(run("pcl_ply2pcd from-ply.ply from-ply.pcd")) << said();

  for (const std::string name : {"from-ply", "from-pcd"}) {
    ASSERT_TRUE(run(fmt::format("pcl_pcd2ply -format 0 {}.pcd back.ply", name))) << said();
    EXPECT_EQ(valid_colours(read_cloud(path("back.ply")).cloud), valid_colours(coloured)) << name;
  }
}

// Open3D has colours from 0 to 1: those of clouds and of .obj in sRGB, those of .glb linear.
TEST_F(OtherPrograms, Open3dReadsTheColoursOfThePicture) {
  const std::string python = "/usr/bin/python3";
  if (!run(python + " -c 'import open3d'")) {
    GTEST_SKIP() << "no Open3D; it is in Debian's python3-open3d";
  }
  const Cloud coloured = coloured_sheet_cloud();
  const Surface surface = surface_of(coloured);
  ASSERT_FALSE(surface.colour.empty());
  std::ofstream(path("colours.py")) << R"(
import sys, numpy, open3d
numpy.seterr(all="raise")
name = sys.argv[1]
if name.startswith("cloud"):
    colours = open3d.io.read_point_cloud(name, remove_nan_points=True).colors
else:
    colours = open3d.io.read_triangle_mesh(name).vertex_colors
colours = numpy.asarray(colours)
if name.endswith(".glb"):
    colours = numpy.where(colours <= 0.0031308, 12.92 * colours,
                          1.055 * numpy.maximum(colours, 0.001) ** (1 / 2.4) - 0.055)
for colour in numpy.rint(255 * colours).astype(int):
    print(*colour)
)";

  const auto seen_by_open3d = [&](const std::string& name) {
    std::vector<Colour> colours;
    EXPECT_TRUE(run(fmt::format("{} colours.py {} >colours.txt", python, name))) << said();
    std::ifstream file(path("colours.txt"));
    for (int red, green, blue; file >> red >> green >> blue;) {
      colours.push_back({static_cast<std::uint8_t>(red), static_cast<std::uint8_t>(green),
                         static_cast<std::uint8_t>(blue)});
    }
    return colours;
  };
  for (const std::string name : {"cloud.ply", "cloud.pcd"}) {
    write_cloud(path(name), coloured);
    EXPECT_EQ(seen_by_open3d(name), valid_colours(coloured)) << name;
  }
  for (const std::string name : {"mesh.ply", "mesh.obj", "mesh.glb"}) {
    write_surface(path(name), surface);
    EXPECT_EQ(seen_by_open3d(name), surface.colour) << name;
  }
}

// OBJ is not tested: Debian's MeshLab aborts on every OBJ file (Debian bug 1054006).
TEST_F(OtherPrograms, MeshLabKeepsColoursAndTriangles) {
  if (!has("meshlabserver") || !has("xvfb-run")) {
    GTEST_SKIP() << "no meshlabserver or xvfb-run; they are in Debian's meshlab and xvfb";
  }
  write_cloud(path("cloud.ply"), cloud_);
  write_surface(path("mesh.ply"), surface_of(cloud_));
  for (const std::string name : {"cloud.ply", "mesh.ply"}) {
    ASSERT_TRUE(run("xvfb-run -a timeout 120 meshlabserver -i " + name + " -o read.ply -m vc"))
        << said();
    const StoredCloud written = read_cloud(path(name)), read = read_cloud(path("read.ply"));
    ASSERT_EQ(point_count(read.cloud), point_count(written.cloud));
    for (std::size_t i = 0; i < read.cloud.z.pixel_count(); ++i) {
      EXPECT_EQ(read.cloud.z.begin()[i], written.cloud.z.begin()[i]);
      EXPECT_NEAR(read.cloud.intensity.begin()[i], written.cloud.intensity.begin()[i], 1e-3);
    }
  }
}

TEST_F(OtherPrograms, CloudCompareKeepsColours) {
  if (!has("CloudCompare")) GTEST_SKIP() << "no CloudCompare; it is in Debian's cloudcompare";
  write_cloud(path("cloud.ply"), cloud_);
  ASSERT_TRUE(
      run("QT_QPA_PLATFORM=offscreen timeout 120 "
          "CloudCompare -SILENT -AUTO_SAVE OFF -O cloud.ply -C_EXPORT_FMT ASC -PREC 4 "
          "-SAVE_CLOUDS FILE read.asc"))
      << said();
  std::ifstream file(path("read.asc"));
  std::size_t points = 0;
  for (std::string line; std::getline(file, line); ++points) {
    std::istringstream words(line);
    double x, y, z, red, green, blue, intensity;
    ASSERT_TRUE(words >> x >> y >> z >> red >> green >> blue >> intensity) << line;
    EXPECT_EQ(red, std::round(intensity));
  }
  EXPECT_EQ(points, point_count(cloud_));
}

// The validator notes every texture whose sides are not powers of two; camera images never are.
TEST_F(OtherPrograms, ValidatorFindsNoErrorInGltf) {
  if (!run("node -e \"require('gltf-validator')\"")) {
    GTEST_SKIP() << "no gltf-validator of npm where NODE_PATH says";
  }
  write_surface(path("mesh.glb"), surface_of(cloud_));
  EXPECT_TRUE(
      run("node -e \"require('gltf-validator')"
          ".validateBytes(new Uint8Array(require('fs').readFileSync('mesh.glb')))"
          ".then(r => { console.log(JSON.stringify(r, null, 1)); const i = r.issues;"
          " process.exit(i.numErrors + i.numWarnings) })\""))
      << said();
}

}  // namespace slipstream::other_programs_test
