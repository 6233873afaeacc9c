// Models of several views as files.
#include "io/model_file.h"

#include <gtest/gtest.h>

#include "slipstream/cloud_file.h"
#include "slipstream/error.h"
#include "tests/io/temporary_folder.h"

namespace slipstream::model_file_test {

FusedModel small_model() {
  FusedModel model{.spacing = 1};
  for (int y = 0; y < 12; ++y) {
    for (int x = 0; x < 12; ++x) {
      model.points.push_back(
          {.position = Eigen::Vector3f(static_cast<float>(x), static_cast<float>(y), 500),
           .normal = -Eigen::Vector3f::UnitZ(),
           .sigma = 0.1F,
           .disagreement = 0.2F,
           .intensity = static_cast<float>(10 * x),
           .views = 2});
    }
  }
  return model;
}

class ModelFile : public testing::TestWithParam<const char*> {};

TEST_P(ModelFile, HasThePointsAndTheirIntensity) {
  const TemporaryFolder folder;
  const std::filesystem::path path = folder.path() / GetParam();
  write_model(path, small_model());

  const StoredCloud stored = read_cloud(path);
  ASSERT_EQ(point_count(stored.cloud), 144U);
  EXPECT_EQ(stored.cloud.x(13, 0), 1);
  EXPECT_EQ(stored.cloud.y(13, 0), 1);
  EXPECT_EQ(stored.cloud.intensity(13, 0), 10);
}

INSTANTIATE_TEST_SUITE_P(Endings, ModelFile, testing::Values("m.ply", "m.pcd", "m.xyz"));

TEST(WriteModel, RefusesOtherEndings) {
  EXPECT_THROW(require_model_ending("model.stl"), Error);
}

TEST(SurfaceOf, GivesEachVertexItsGreyLevel) {
  const Surface surface = surface_of(mesh_of(small_model()));
  ASSERT_FALSE(surface.triangles.empty());
  for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
    const auto column = static_cast<int>(surface.texture[i].x() * 256);
    EXPECT_EQ(surface.picture(column, 0), grey_level(surface.intensity[i]));
  }
}

}  // namespace slipstream::model_file_test
