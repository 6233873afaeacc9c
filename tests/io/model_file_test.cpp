// Models of several views as files.
#include "io/model_file.h"

#include <memory>
#include <string>

#include <gtest/gtest.h>

#include "io/file.h"
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

TEST(ModelFileWriteModel, RefusesOtherEndings) {
  EXPECT_THROW(require_model_ending("model.stl"), Error);
}

TEST(ModelFileSurfaceOf, GivesEachVertexItsGreyLevel) {
  const Surface surface = surface_of(mesh_of(small_model()));
  ASSERT_FALSE(surface.triangles.empty());
  for (std::size_t i = 0; i < surface.vertices.size(); ++i) {
    const auto column = static_cast<int>(surface.texture[i].x() * 256);
    EXPECT_EQ(surface.picture(column, 0), grey_level(surface.intensity[i]));
  }
}

TEST(ModelFileWriteModel, NamesTheFrame) {
  FusedModel model = small_model();
  model.frame = std::make_shared<const FramePose>(
      FramePose{"camera", "robot_base", Eigen::Isometry3d(Eigen::Translation3d(1, 2, 3))});

  const TemporaryFolder folder;
  for (const char* const name : {"m.ply", "m.pcd"}) {
    SCOPED_TRACE(name);
    write_model(folder.path() / name, model);
    const Cloud cloud = read_cloud(folder.path() / name).cloud;
    ASSERT_EQ(frame_name(cloud), "robot_base");
    EXPECT_TRUE(cloud.frame->transform.isApprox(model.frame->transform));
    EXPECT_EQ(cloud.x(13, 0), 1);
  }
}

TEST(ModelFileSurfaceOf, HasItsColoursInObjWithoutAGreyTextureOverThem) {
  FusedModel model = small_model();
  model.coloured = true;
  for (ModelPoint& point : model.points) point.colour = {200, 100, 50};

  const TemporaryFolder folder;
  write_surface(folder.path() / "m.obj", surface_of(mesh_of(model)));
  EXPECT_NE(read_text(folder.path() / "m.obj").find(" 0.78431 0.39216 0.19608\n"),
            std::string::npos);
  EXPECT_EQ(read_text(folder.path() / "m.mtl").find("map_Kd"), std::string::npos);

  write_surface(folder.path() / "grey.obj", surface_of(mesh_of(small_model())));
  EXPECT_NE(read_text(folder.path() / "grey.mtl").find("map_Kd"), std::string::npos);
}

}  // namespace slipstream::model_file_test
