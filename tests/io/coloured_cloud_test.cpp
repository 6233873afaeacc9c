// Writes clouds in colour and reads them by the written rules of each format.
#include <cmath>
#include <cstdint>
#include <cstring>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "io/file.h"
#include "io/picture_file.h"
#include "io/pictures.h"
#include "slipstream/cloud_file.h"
#include "slipstream/surface.h"
#include "tests/io/sheet_cloud.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::coloured_cloud_test {
namespace fs = std::filesystem;

std::string text_in(const fs::path& path) {
  const std::vector<std::uint8_t> bytes = read_file(path);
  return {bytes.begin(), bytes.end()};
}

class ColouredCloud : public testing::Test {
 protected:
  [[nodiscard]] fs::path path(const std::string& name) const { return folder_.path() / name; }

  const Cloud cloud_ = coloured_sheet_cloud();

 private:
  TemporaryFolder folder_;
};

TEST_F(ColouredCloud, InPlyHasThePicturesBytes) {
  write_cloud(path("cloud.ply"), cloud_);
  const std::string file = text_in(path("cloud.ply"));
  const std::size_t data = file.find("end_header\n") + 11;

  // Four numbers of which the last is a double, then red, green and blue.
  constexpr std::size_t stride = 3 * 4 + 8 + 3;
  const std::vector<Colour> expected = valid_colours(cloud_);
  ASSERT_EQ(file.size(), data + expected.size() * stride);
  for (std::size_t i = 0; i < expected.size(); ++i) {
    Colour read;
    std::memcpy(&read, file.data() + data + i * stride + 20, 3);
    EXPECT_EQ(read, expected[i]);
  }
}

TEST_F(ColouredCloud, InPcdIsPackedInAFloat) {
  write_cloud(path("cloud.pcd"), cloud_);
  const std::string file = text_in(path("cloud.pcd"));
  EXPECT_NE(file.find("FIELDS x y z intensity rgb\nSIZE 4 4 4 4 4\nTYPE F F F F F\n"),
            std::string::npos);

  const std::size_t data = file.find("DATA binary\n") + 12;
  ASSERT_EQ(file.size(), data + cloud_.z.pixel_count() * 20);
  for (std::size_t i = 0; i < cloud_.z.pixel_count(); ++i) {
    std::uint32_t packed = 0;
    std::memcpy(&packed, file.data() + data + i * 20 + 16, 4);
    const auto [red, green, blue] = cloud_.colour.begin()[i];
    EXPECT_EQ(packed, std::uint32_t{red} << 16U | std::uint32_t{green} << 8U | blue);
  }
}

TEST_F(ColouredCloud, InObjHasSharesOfSrgbAndATextureInColour) {
  const Surface surface = surface_of(cloud_);
  write_surface(path("mesh.obj"), surface);

  std::istringstream lines(text_in(path("mesh.obj")));
  std::size_t vertex = 0;
  for (std::string word; lines >> word;) {
    if (word != "v") continue;
    double x = 0, y = 0, z = 0, red = 0, green = 0, blue = 0;
    lines >> x >> y >> z >> red >> green >> blue;
    EXPECT_NEAR(255 * red, surface.colour[vertex].red, 0.01);
    EXPECT_NEAR(255 * green, surface.colour[vertex].green, 0.01);
    EXPECT_NEAR(255 * blue, surface.colour[vertex].blue, 0.01);
    ++vertex;
  }
  EXPECT_EQ(vertex, surface.vertices.size());

  const Picture texture = read_picture(path("mesh-texture.png"), 1);
  ASSERT_EQ(texture.kind.channels, 3);
  const auto& samples = std::get<Image<std::uint8_t>>(texture.samples);
  EXPECT_EQ(std::memcmp(samples.begin(), cloud_.colour.begin(), samples.pixel_count()), 0);
}

TEST_F(ColouredCloud, InGltfIsLinearAndWithoutATextureThatWouldMultiplyIt) {
  const Surface surface = surface_of(cloud_);
  write_surface(path("mesh.glb"), surface);
  const std::string file = text_in(path("mesh.glb"));

  std::uint32_t length = 0;
  std::memcpy(&length, file.data() + 12, 4);
  const auto document = nlohmann::json::parse(file.substr(20, length));
  const auto& primitive = document["meshes"][0]["primitives"][0];
  const std::size_t colours = primitive["attributes"]["COLOR_0"];
  const auto& accessor = document["accessors"][colours];
  EXPECT_EQ(accessor["componentType"], 5123) << "unsigned short";
  EXPECT_EQ(accessor["type"], "VEC4");
  EXPECT_EQ(accessor["normalized"], true);
  EXPECT_EQ(accessor["count"], surface.colour.size());
  EXPECT_FALSE(document.contains("textures"));
  EXPECT_FALSE(document["materials"][0]["pbrMetallicRoughness"].contains("baseColorTexture"));

  const std::size_t view = accessor["bufferView"];
  const std::size_t offset = document["bufferViews"][view]["byteOffset"];
  EXPECT_EQ(offset % 4, 0U);
  const char* at = file.data() + 20 + length + 8 + offset;
  for (const auto& [red, green, blue] : surface.colour) {
    std::array<std::uint16_t, 4> stored{};
    std::memcpy(stored.data(), at, sizeof stored);
    at += sizeof stored;

    // The curve of sRGB, by the standard.
    const std::array<double, 3> shares{red / 255.0, green / 255.0, blue / 255.0};
    for (std::size_t c = 0; c < 3; ++c) {
      const double light =
          shares[c] <= 0.04045 ? shares[c] / 12.92 : std::pow((shares[c] + 0.055) / 1.055, 2.4);
      EXPECT_NEAR(stored[c], 65535 * light, 0.5001);
    }
    EXPECT_EQ(stored[3], 65535);
  }
}

TEST_F(ColouredCloud, IsReadBackWithItsColours) {
  for (const char* name : {"cloud.ply", "cloud.pcd"}) {
    write_cloud(path(name), cloud_);
    const StoredCloud stored = read_cloud(path(name));
    EXPECT_EQ(valid_colours(stored.cloud), valid_colours(cloud_)) << name;
  }

  // Every level of a channel: light is stored by a curve.
  Surface surface = surface_of(cloud_);
  ASSERT_GE(surface.colour.size(), 256U);
  for (std::size_t i = 0; i < 256; ++i) surface.colour[i].red = static_cast<std::uint8_t>(i);

  for (const char* name : {"mesh.ply", "mesh.obj", "mesh.glb"}) {
    write_surface(path(name), surface);
    EXPECT_EQ(valid_colours(read_cloud(path(name)).cloud), surface.colour) << name;
  }
}

TEST_F(ColouredCloud, IsGreyWithoutColours) {
  write_cloud(path("cloud.ply"), sheet_cloud());
  EXPECT_TRUE(read_cloud(path("cloud.ply")).cloud.colour.empty());
}

TEST_F(ColouredCloud, OfRealNumbersIsReadInBytes) {
  write_file(path("shares.ply"),
             "ply\nformat ascii 1.0\nelement vertex 2\nproperty float x\nproperty float y\n"
             "property float z\nproperty float intensity\nproperty float red\n"
             "property float green\nproperty float blue\nend_header\n"
             "0 0 1 77 1 0.2 0\n0 1 1 99 0 0.4 1\n");
  const Cloud cloud = read_cloud(path("shares.ply")).cloud;
  ASSERT_EQ(cloud.colour.pixel_count(), 2U);
  EXPECT_EQ(cloud.colour(0, 0), (Colour{255, 51, 0}));
  EXPECT_EQ(cloud.colour(1, 0), (Colour{0, 102, 255}));
  EXPECT_EQ(cloud.intensity(1, 0), 99) << "stays as it is";
}

}  // namespace slipstream::coloured_cloud_test
