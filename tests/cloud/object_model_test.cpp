// Clouds of an object that turns before the virtual camera, as depth and noise alone make them.
#include "cloud/object_model.h"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include "simulate/seen_scene.h"
#include "slipstream/cloud.h"
#include "slipstream/error.h"
#include "slipstream/named_scenes.h"
#include "slipstream/scanner.h"

namespace slipstream::object_model_test {

/// A box with spheres and another box on it, that turns by a degree from view to view.
Scene turning_object(const Scanner& scanner) {
  const Eigen::Vector3d middle = working_volume(scanner).centre;
  const auto at = [&](double x, double y, double z) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    pose.translate(middle + Eigen::Vector3d(x, y, z));
    pose.rotate(Eigen::AngleAxisd(0.3, Eigen::Vector3d(1, 2, 0.5).normalized()));
    return pose;
  };
  Scene scene{Body{.shape = Box{{90, 150, 60}}, .pose = at(0, 0, 0)},
              Body{.shape = Sphere{35}, .pose = at(30, -60, -20)},
              Body{.shape = Sphere{28}, .pose = at(-25, 20, 30)},
              Body{.shape = Sphere{22}, .pose = at(-35, 60, -30)},
              Body{.shape = Box{{50, 40, 70}}, .pose = at(35, 50, 15)}};
  for (Body& body : scene) {
    body.motion = {.turn = {0, std::numbers::pi / 180, 0}, .centre = middle};
  }
  return scene;
}

class DepthCamera {
 public:
  DepthCamera(Scanner scanner, double sigma) : scanner_(std::move(scanner)), noise_(0, sigma) {
    const Size size = scanner_.camera.size;
    for (int row = 0; row < size.height; ++row) {
      for (int column = 0; column < size.width; ++column) {
        rays_.push_back(ray_through(scanner_.camera, {column, row}));
      }
    }
  }

  Cloud see(const Scene& scene, double time) {
    const SeenScene seen = look(scanner_, scene, {}, time);
    Cloud cloud(scanner_.camera.size);
    for (std::size_t i = 0; i < cloud.z.pixel_count(); ++i) {
      if (std::isnan(seen.lit_column.begin()[i])) continue;  // no surface, or in shadow
      const Eigen::Vector3d point = (seen.depth.begin()[i] + noise_(random_)) * rays_[i];
      cloud.x.begin()[i] = static_cast<float>(point.x());
      cloud.y.begin()[i] = static_cast<float>(point.y());
      cloud.z.begin()[i] = static_cast<float>(point.z());
      cloud.validity.begin()[i] = Validity::valid;
    }
    return cloud;
  }

 private:
  Scanner scanner_;
  std::normal_distribution<double> noise_;
  std::mt19937 random_{1};
  std::vector<Eigen::Vector3d> rays_;
};

using Vector = Eigen::Vector3d;

/// How far the points of a model lie from the surfaces of the scene at time 0, mm.
struct ModelError {
  double rms = 0, mean = 0;
  double flying = 0;  // share farther than 2 mm from all
};

ModelError error_of(const ModelPoints& model, const Scene& truth) {
  constexpr double reach = 2;
  ModelError error;
  double near = 0;
  const int count = model.cloud.size().width;
  for (int i = 0; i < count; ++i) {
    const Vector point(model.cloud.x(i, 0), model.cloud.y(i, 0), model.cloud.z(i, 0));
    const Vector normal(model.normals.x(i, 0), model.normals.y(i, 0), model.normals.z(i, 0));
    const auto surface = first_surface(placed_at(truth, 0), {point + reach * normal, -normal});
    const double distance = surface ? reach - surface->distance : INFINITY;
    if (!(std::abs(distance) < reach)) {
      error.flying += 1.0 / count;
      continue;
    }
    ++near;
    error.mean += distance;
    error.rms += distance * distance;
  }
  error.mean /= near;
  error.rms = std::sqrt(error.rms / near);
  return error;
}

TEST(ObjectModel, OfAWholeTurnIsTheObject) {
  const Scanner scanner = example_scanner({320, 240});
  const Scene scene = turning_object(scanner);
  DepthCamera camera(scanner, 0.05);
  ObjectModel model(scanner.camera);
  double worst_turn = 0;
  for (int view = 0; view < 360; ++view) {
    ASSERT_TRUE(model.add(camera.see(scene, view), view)) << view;
    const Eigen::Affine3d moved = scene.front().motion.at(view);
    const Eigen::Matrix3d off = model.registration().pose.linear() * moved.linear().transpose();
    worst_turn = std::max(worst_turn, Eigen::AngleAxisd(off).angle());
  }
  const ModelError error = error_of(model.points(), scene);
  RecordProperty("rms", std::to_string(error.rms));
  RecordProperty("mean", std::to_string(error.mean));
  RecordProperty("flying", std::to_string(error.flying));
  RecordProperty("elements", static_cast<int>(model.elements().size()));
  RecordProperty("points", model.points().cloud.size().width);
  RecordProperty("worst_turn", std::to_string(worst_turn * 180 / std::numbers::pi));
  EXPECT_LT(error.rms, 0.1);
  EXPECT_LT(error.flying, 0.005);
  EXPECT_LT(worst_turn, 0.1 * std::numbers::pi / 180);
  EXPECT_EQ(model.left_out(), 0);
}

TEST(ObjectModel, GoesOnWhereViewsAreMissed) {
  const Scanner scanner = example_scanner({160, 120});
  const Scene scene = turning_object(scanner);
  DepthCamera camera(scanner, 0.05);
  ObjectModel model(scanner.camera);
  for (const int view : {0, 1, 2, 3, 4, 5, 20, 22, 24, 40, 44, 65}) {
    EXPECT_TRUE(model.add(camera.see(scene, view), view)) << view;
  }
  const Eigen::Matrix3d truth = scene.front().motion.at(65).linear();
  EXPECT_LT(Eigen::AngleAxisd(model.registration().pose.linear() * truth.transpose()).angle(),
            0.01);
}

TEST(ObjectModel, LeavesOutWhatDoesNotFit) {
  const Scanner scanner = example_scanner({160, 120});
  const Scene scene = turning_object(scanner);
  DepthCamera camera(scanner, 0.05);
  ObjectModel model(scanner.camera);
  EXPECT_FALSE(model.add(Cloud({160, 120}), 4));
  for (int view = 0; view < 4; ++view) EXPECT_TRUE(model.add(camera.see(scene, view), view));
  EXPECT_FALSE(model.add(camera.see(scene, 120), 4));
  EXPECT_FALSE(model.add(Cloud({160, 120}), 4));
  EXPECT_EQ(model.left_out(), 3);
  EXPECT_EQ(model.views(), 4);
  EXPECT_TRUE(model.add(camera.see(scene, 4), 4));
  EXPECT_THROW((void)model.add(Cloud({16, 12}), 5), Error);
}

/// A few more points than a model needs to begin. A hole shows points behind it that are too far
/// apart for a surface.
Cloud small_wall(const Lens& camera, bool with_hole) {
  Cloud cloud(camera.size);
  for_each_pixel_in_order({44, 25}, [&](int column, int row) {
    const bool in_hole = with_hole && column < 15 && row < 15;
    const double behind = (column + row) % 2 == 0 ? 1500 : 2000;
    const Vector point = (in_hole ? behind : 600) * ray_through(camera, {60 + column, 40 + row});

    cloud.x(60 + column, 40 + row) = static_cast<float>(point.x());
    cloud.y(60 + column, 40 + row) = static_cast<float>(point.y());
    cloud.z(60 + column, 40 + row) = static_cast<float>(point.z());
  });
  return cloud;
}

TEST(ObjectModel, GoesOnWithFewerElementsThanItBegan) {
  const Lens camera = example_scanner({160, 120}).camera;
  ObjectModel model(camera);
  EXPECT_TRUE(model.add(small_wall(camera, false), 0));
  for (const int time : {1, 2}) EXPECT_TRUE(model.add(small_wall(camera, true), time)) << time;
  EXPECT_EQ(model.views(), 3);
  EXPECT_GT(model.elements().size(), 800U);
  EXPECT_LT(model.elements().size(), 1000U) << "those seen through are gone";
}

TEST(ObjectModel, RegistrationFindsAPoseFromNearIt) {
  const Scanner scanner = example_scanner({320, 240});
  const Scene scene = turning_object(scanner);
  DepthCamera camera(scanner, 0);
  ObjectModel model(scanner.camera);
  (void)model.add(camera.see(scene, 0), 0);
  const Cloud cloud = camera.see(scene, 2.5);
  const Registration found = register_to(model.elements(), cloud, smoothed_normals(cloud),
                                         scanner.camera, Eigen::Isometry3d::Identity());
  const Eigen::Isometry3d truth(scene.front().motion.at(2.5).matrix());
  const Vector middle = scene.front().motion.centre;
  EXPECT_LT((found.pose * middle - truth * middle).norm(), 0.05);
  EXPECT_TRUE(found.pose.linear().isApprox(truth.linear(), 1e-3));
  EXPECT_GT(found.share, 0.9);
}

TEST(ObjectModel, RegistrationLeavesATurnOfASphereAsItIs) {
  const Scanner scanner = example_scanner({160, 120});
  const Scene scene = scene_named("sphere", scanner);
  DepthCamera camera(scanner, 0.05);
  ObjectModel model(scanner.camera);
  for (int view = 0; view < 20; ++view) EXPECT_TRUE(model.add(camera.see(scene, 0), view));
  const Vector centre = working_volume(scanner).centre;
  EXPECT_LT((model.registration().pose * centre - centre).norm(), 0.05);
  EXPECT_LT(Eigen::AngleAxisd(model.registration().pose.linear()).angle(), 0.02);
}

}  // namespace slipstream::object_model_test
