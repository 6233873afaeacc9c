#include "slipstream/surface.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>

namespace slipstream::surface_test {

/// A sheet across the view, 500 mm away; from column `edge` on 560 mm.
Cloud sheet(Size size, int edge) {
  Cloud cloud(size);
  for (int row = 0; row < size.height; ++row) {
    for (int column = 0; column < size.width; ++column) {
      const float z = column < edge ? 500 : 560;
      cloud.x(column, row) = z * static_cast<float>(column - 10) / 100;
      cloud.y(column, row) = z * static_cast<float>(row - 5) / 100;
      cloud.z(column, row) = z;
      cloud.intensity(column, row) = static_cast<float>(column + 10 * row);
      cloud.validity(column, row) = Validity::valid;
    }
  }
  return cloud;
}

void leave_out(Cloud& cloud, int column, int row) {
  cloud.x(column, row) = cloud.y(column, row) = cloud.z(column, row) = std::nanf("");
  cloud.validity(column, row) = Validity::too_dark;
}

void expect_sound(const Surface& surface) {
  ASSERT_EQ(surface.intensity.size(), surface.vertices.size());
  ASSERT_EQ(surface.texture.size(), surface.vertices.size());
  for (const auto& [a, b, c] : surface.triangles) {
    const Eigen::Vector3f first = surface.vertices.at(a), second = surface.vertices.at(b),
                          third = surface.vertices.at(c);
    EXPECT_LT((second - first).cross(third - first).dot(first), 0);  // turned to the camera
  }
}

TEST(Surface, JoinsNeighbours) {
  const Surface surface = surface_of(sheet({20, 10}, 20));
  EXPECT_EQ(surface.vertices.size(), 200U);
  EXPECT_EQ(surface.triangles.size(), 2U * 19 * 9);
  expect_sound(surface);
  EXPECT_EQ(surface.picture(7, 3), 37);
}

TEST(Surface, IsCutAtAStepInDepth) {
  const Surface surface = surface_of(sheet({20, 10}, 8));
  EXPECT_EQ(surface.triangles.size(), 2U * 18 * 9);
  for (const auto& [a, b, c] : surface.triangles) {
    EXPECT_EQ(surface.vertices[a].z(), surface.vertices[b].z());
    EXPECT_EQ(surface.vertices[a].z(), surface.vertices[c].z());
  }
}

TEST(Surface, GoesRoundMissingPoints) {
  for (const auto [column, row] : {std::pair(5, 5), std::pair(0, 0), std::pair(19, 9)}) {
    Cloud cloud = sheet({20, 10}, 20);
    leave_out(cloud, column, row);
    const Surface surface = surface_of(cloud);
    EXPECT_EQ(surface.vertices.size(), 199U);
    // Each block about the pixel keeps one of its two triangles.
    EXPECT_EQ(surface.triangles.size(), 2U * 19 * 9 - (column == 5 ? 4U : 1U));
    expect_sound(surface);
  }
}

TEST(Surface, HasNoVertexWithoutTriangle) {
  Cloud cloud = sheet({3, 3}, 3);
  for (int i = 0; i < 3; ++i) leave_out(cloud, 1, i);
  const Surface surface = surface_of(cloud);
  EXPECT_TRUE(surface.triangles.empty());
  EXPECT_TRUE(surface.vertices.empty());
}

TEST(Surface, PlacesEachVertexInThePicture) {
  const Surface surface = surface_of(sheet({20, 10}, 20));
  for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
    const auto column = static_cast<int>(surface.texture[i].x() * 20);
    const auto row = static_cast<int>(surface.texture[i].y() * 10);
    EXPECT_EQ(static_cast<float>(surface.picture(column, row)), surface.intensity[i]);
  }
}

}  // namespace slipstream::surface_test
